"""The record of an episode: enough to draw it, to measure it and to run it again bit for bit.

``R`` is the number of robots, ``P`` of people, ``T`` of steps and ``F = T + 1`` of frames; frame 0
is the state after ``reset``. The record of a ``WarehouseEnv`` has lists with an entry a frame or a
step. The record of a ``FleetEnv`` has arrays with an axis more, for the robots. The file format is
in ``arrays.py`` and ``files/npz.py``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.batch.tally import FleetMeasures
from warehouse_core.errors import RecordError
from warehouse_core.files.npz import read_arrays, write_arrays
from warehouse_core.orders.order import Order
from warehouse_core.records.arrays import SCHEMAS, is_equal, pack, schema_of, unpack
from warehouse_core.task.settings import Settings
from warehouse_core.wording import counted
from warehouse_core.world.actions import INVALID
from warehouse_core.world.display import display
from warehouse_core.world.layout import Layout
from warehouse_core.world.moves import COUNTS_AS, TURN_ACTIONS
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED, Cell, manhattan_distance

DELIVERED = "delivered"
BATTERY_DEPLETED = "battery depleted"
OUT_OF_TIME = "out of time"
UNFINISHED = "unfinished"

Action = str | int
GridFrame = list[list[str]]

Column = Any
"""A list of a lone robot's values, or an array of a fleet's; ``Episode`` says which values."""

NOT_MEASURED = FleetMeasures(
    0, 0.0, 0, 0, math.nan, math.nan, math.nan, math.nan, 0.0, math.nan, 0, 0, 0, 0, 0, 0
)
"""Measures of a lone robot, whose record says the same in ``metrics``."""


@dataclass(slots=True, eq=False)
class Episode:
    """The record of one episode. Two records are equal when every value in them is.

    The first shape is the record of a lone robot, the second the record of a fleet. Arrays are not
    to be changed. Cells of a fleet are numbers, ``row * W + col``.

    Attributes:
        layout: Walls, stations and chargers during the episode.
        settings: Arguments of the environment, ``Settings`` or ``FleetSettings``.
        seed: Seed given to ``reset``, or ``None``; a fleet always has one.
        agent: Name of the agent.
        cells: ``[F]`` cells, or ``[F, R]`` int32: where the robots were.
        loaded: ``[F]`` or ``[F, R]`` bool, whether they held an item.
        battery: ``[F]`` int or ``[F, R]`` float64, units left.
        rewards: ``[F]`` reward of the step before the frame, first a 0; or ``[T, R]`` float64.
        actions: ``[T]`` words and indices as the agent gave them; or ``[T, R]`` int8 indices,
            ``INVALID`` for those that are not allowed, see ``unknown_actions``.
        reasons: ``[T]`` reasons that the agent gave, "" for none; for a fleet tuples of ``R``,
            and no entries if the agent gave none at all.
        motions: ``[T]`` outcomes of the motion backend; for a fleet tuples of the outcomes of the
            robots and then the people, and no entries if the robots drive straight from cell to
            cell.
        terminated: ``True`` if the task is done; or ``[R]`` bool.
        truncated: ``True`` if the battery or the steps are used up; or ``[R]`` bool.
        backend: Name of the motion backend, or of its class.
        cell_size: Side of a cell in metres.
        slippery: Open cells whose floor the backend says is slippery.
        motor_strength: Actual share of the motor force.
        unknown_actions: Actions of a fleet that are not allowed, as given, by step and robot.
        people: ``[F, P]`` int32, where the people were; () for a lone robot.
        headings: ``[F, R]`` int8, 0 to 3 for N, E, S and W, where the robots headed; () without
            headings.
        stopped_by: ``[T, R]`` int32, what blocked a move, see ``BatchOutcome``; people have the
            numbers from ``R`` on. () for a lone robot.
        step_seconds: ``[T, R]`` float64, duration of each motion; () for a lone robot.
        step_joules: ``[T, R]`` float64, cost of each motion; () for a lone robot.
        orders: Orders released, and what has become of them.
        assignments: Calls of ``FleetEnv.assign``: steps taken before, robot, and order or ``None``.
        measures: Measures of a fleet over the whole episode.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import Episode, WarehouseEnv, record_episode
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> episode.save("episode.npz")
        >>> Episode.load("episode.npz") == episode
        True
    """

    layout: Layout
    settings: Any
    seed: int | None
    agent: str
    cells: Column = field(default_factory=list)
    loaded: Column = field(default_factory=list)
    battery: Column = field(default_factory=list)
    rewards: Column = field(default_factory=list)
    actions: Column = field(default_factory=list)
    reasons: list[Any] = field(default_factory=list)
    motions: list[Any] = field(default_factory=list)
    terminated: Any = False
    truncated: Any = False
    backend: str = ""
    cell_size: float = 1.0
    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0
    unknown_actions: dict[tuple[int, int], Action] = field(default_factory=dict)
    people: Column = ()
    headings: Column = ()
    stopped_by: Column = ()
    step_seconds: Column = ()
    step_joules: Column = ()
    orders: list[Order] = field(default_factory=list)
    assignments: list[tuple[int, int, int | None]] = field(default_factory=list)
    measures: FleetMeasures = NOT_MEASURED

    _repr_html_ = display  # which notebooks call

    def __post_init__(self) -> None:
        settings = self.settings
        if isinstance(settings, Settings):
            self.backend, self.cell_size = settings.backend, settings.cell_size
            self.slippery, self.motor_strength = settings.slippery, settings.motor_strength

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Episode):
            return NotImplemented
        return not any(self._differences(other))

    def __repr__(self) -> str:
        robots = f"{counted(self.robots, 'robot')}, " if self.is_fleet else ""
        result = f"{self.outcome}, {counted(self.steps, 'step')}, reward {self.total_reward:.2f}"
        return f"<Episode {robots}{result}, seed {self.seed}, agent {self.agent!r}>"

    @property
    def is_fleet(self) -> bool:
        """Whether the record has an axis for the robots, as the record of a ``FleetEnv`` has."""
        return isinstance(self.settings, FleetSettings)

    @property
    def robots(self) -> int:
        """``R``, the number of robots."""
        return self.settings.robots if self.is_fleet else 1

    @property
    def steps(self) -> int:
        """``T``, the length of the episode."""
        return len(self.actions)

    @property
    def total_reward(self) -> float:
        """The sum of all rewards, rounded to nine decimals: 14.6, not 14.600000000000001."""
        return round(math.fsum(np.ravel(self.rewards)), 9)

    @property
    def seconds(self) -> Any:
        """The simulated time that all motions of a lone robot took; or ``step_seconds``."""
        return self.step_seconds if self.is_fleet else math.fsum(m.seconds for m in self.motions)

    @property
    def joules(self) -> Any:
        """The energy that all motions of a lone robot cost; or ``step_joules``."""
        return self.step_joules if self.is_fleet else math.fsum(m.joules for m in self.motions)

    @property
    def outcome(self) -> str:
        """How it ended, or how many items of a fleet were delivered.

        A delivery with the last battery unit is a delivery.
        """
        if self.is_fleet:
            items = counted(self.robots, "item")
            if self.settings.orders is not None:
                items = counted(len(self.orders), "order")
            return f"{self.measures.delivered:,} of {items} delivered"
        if self.terminated:
            return DELIVERED
        if self.battery and self.battery[-1] <= 0:
            return BATTERY_DEPLETED
        return OUT_OF_TIME if self.truncated else UNFINISHED

    @property
    def words(self) -> list[Any]:
        """``[T]`` the actions of a lone robot; for a fleet tuples of ``R``, in words.

        An action that is not allowed is as the agent gave it, or ``INVALID`` if that is not known.
        """
        if not self.is_fleet:
            return list(self.actions)
        words: dict[int, Action] = {
            **dict(enumerate(self.settings.actions.words)),
            INVALID: INVALID,
        }
        return [
            tuple(self.unknown_actions.get((step, robot), words[action])
                  for robot, action in enumerate(actions))
            for step, actions in enumerate(self.actions.tolist())
        ]  # fmt: skip

    def counted_actions(self, steps: int | slice = slice(None)) -> NDArray[np.integer]:
        """Return what the actions of a fleet in some steps count as; see ``world/moves.py``.

        Args:
            steps: a step, or ``T`` of them; all if none are given.

        Returns:
            ``[R]`` or ``[T, R]`` indices into ``ACTIONS``, or ``INVALID``.
        """
        actions: NDArray[np.integer] = self.actions[steps]
        if not self.settings.has_headings:
            return actions
        known = np.minimum(actions, len(TURN_ACTIONS) - 1)
        return np.where(actions == INVALID, INVALID, COUNTS_AS[self.headings[:-1][steps], known])

    @property
    def frames(self) -> list[GridFrame]:
        """``[F]`` frames as ``WarehouseEnv.render_grid`` returned them, as new lists.

        Every robot of a fleet is shown as the lone robot is, and people are shown too.
        """
        frames = []
        for bodies in self._bodies():
            frame = [list(line) for line in self.layout.rows]
            for (row, col), character in bodies:
                frame[row][col] = character
            frames.append(frame)
        return frames

    @property
    def metrics(self) -> dict[str, list[float]]:
        """The chapter's four lists of one robot, one entry a frame; empty for several robots.

        Distances are NaN without a station. With orders, which change the stations, there are none.
        """
        if self.robots > 1:
            return {}
        cells, battery, rewards = self.cells, self.battery, self.rewards
        if self.is_fleet:
            cells = self.layout.cells(cells[:, 0])
            battery, rewards = battery[:, 0].tolist(), [0.0, *rewards[:, 0].tolist()]
        metrics = {"rewards": list(rewards), "battery": [float(units) for units in battery]}
        if not self.is_fleet or self.settings.orders is None:
            metrics["dist_pickup"] = _distances(cells, self.layout.pickups)
            metrics["dist_dropoff"] = _distances(cells, self.layout.dropoffs)
        return metrics

    def save(self, path: str | Path) -> None:
        """Write the record to a ``.npz`` file, whole or not at all.

        Raises:
            RecordError: it is larger than ``npz.MAX_BYTES``, which paths of many robots soon are
                (``motions`` may be emptied), has more than ``arrays.MAX_OBJECTS`` motions and
                other objects, or ``load`` would not return it.
            OSError: the file cannot be written.
        """
        try:
            arrays = pack({name: getattr(self, name) for name in self.__slots__})
            changed = next(self._differences(Episode(**unpack(arrays))), None)
        except RecordError as error:
            raise RecordError(f"{path}: {error}") from error
        except (TypeError, ValueError, AttributeError, OverflowError) as error:
            raise RecordError(f"{path}: the fields cannot be stored: {error}") from error
        if changed:
            raise RecordError(f"{path}: {changed} would be loaded with other values or types")
        write_arrays(path, arrays, schema_of(arrays))

    @staticmethod
    def load(path: str | Path) -> Episode:
        """Read a record from a ``.npz`` file that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or no record; the message names what is wrong.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, *SCHEMAS)
        try:
            return Episode(**unpack(arrays))
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error

    def _differences(self, other: Episode) -> Iterator[str]:
        """Yield the fields in which another record differs."""
        for name in self.__slots__:
            if not is_equal(getattr(self, name), getattr(other, name)):
                yield name

    def _bodies(self) -> Iterator[Iterator[tuple[Cell, str]]]:
        """Yield for each frame the cells of robots and people, and their characters."""
        loads = (ROBOT_EMPTY, ROBOT_LOADED)
        if not self.is_fleet:
            for cell, loaded in zip(self.cells, self.loaded, strict=True):
                yield iter([(cell, loads[loaded])])
            return
        people = [PERSON] * self.people.shape[1]
        bodies = np.hstack([self.cells, self.people])
        for cells, loaded in zip(bodies, self.loaded.tolist(), strict=True):
            tiles = [*(loads[each] for each in loaded), *people]
            yield zip(self.layout.cells(cells), tiles, strict=True)


def _distances(cells: Sequence[Cell], stations: Sequence[Cell]) -> list[float]:
    """Return the distance from each cell to the first of the stations."""
    if not stations:
        return [math.nan] * len(cells)
    return [float(manhattan_distance(cell, stations[0])) for cell in cells]


FleetEpisode = Episode
