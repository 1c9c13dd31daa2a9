"""The record of an episode: enough to draw it, to measure it and to run it again bit for bit.

``R`` is the number of robots, ``P`` the number of people, ``T`` the number of steps and
``F = T + 1`` the number of frames; frame 0 is the state after ``reset``. The record of a
``WarehouseEnv`` has lists with one entry for each frame or step. The record of a ``FleetEnv`` has
arrays with one more axis, for the robots. The file format is defined in ``arrays.py`` and
``files/npz.py``.
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

DRIVE = "drive"
"""Name of the backend in records of continuous control."""

Action = str | int
GridFrame = list[list[str]]

Column = Any
"""A list of values of a single robot, or an array of values of a fleet; see ``Episode``."""

NOT_MEASURED = FleetMeasures(
    0, 0.0, 0, 0, math.nan, math.nan, math.nan, math.nan, 0.0, math.nan, 0, 0, 0, 0, 0, 0
)
"""Placeholder in the record of a single robot, which has ``metrics`` instead of measures."""


@dataclass(slots=True, eq=False)
class Episode:
    """The record of one episode. Two records are equal if all their values are equal.

    Where two shapes are given, the first is for a single robot and the second for a fleet. Do not
    change the arrays. The cells of a fleet are numbers, ``row * W + col``.

    Attributes:
        layout: Walls, stations and chargers during the episode.
        settings: Arguments of the environment, ``Settings`` or ``FleetSettings``.
        seed: Seed given to ``reset``, or ``None``; the record of a fleet always has a seed.
        agent: Name of the agent.
        cells: ``[F]`` cells, or ``[F, R]`` int32: cells of the robots.
        loaded: ``[F]`` or ``[F, R]`` bool: whether the robots held an item.
        battery: ``[F]`` int or ``[F, R]`` float64: battery units left.
        rewards: ``[F]`` reward of the step before each frame, beginning with 0; or ``[T, R]``
            float64.
        actions: ``[T]`` words and indices as the agent gave them; or ``[T, R]`` int8 indices, with
            ``INVALID`` for actions that do not exist.
        reasons: ``[T]`` reasons that the agent gave, "" for none. For a fleet tuples of ``R``
            reasons, or an empty list if the agent never gave any.
        motions: ``[T]`` outcomes of the motion backend. For a fleet tuples with the outcomes of
            the robots and then of the people, or an empty list if the robots drive straight from
            cell to cell.
        terminated: ``True`` if the task is done; or ``[R]`` bool.
        truncated: ``True`` if the battery is empty or the step limit is reached; or ``[R]`` bool.
        backend: Name of the motion backend, or of its class.
        cell_size: Side of a cell in metres.
        slippery: Open cells that the backend reports as slippery.
        motor_strength: Actual motor force, as a share of the nominal force.
        drive: Drive of the robots as the backend reports it, such as ``"differential"``.
        people: ``[F, P]`` int32: cells of the people; () for a single robot.
        headings: ``[F, R]`` int8: headings of the robots, 0 to 3 for N, E, S and W; () without
            headings.
        stopped_by: ``[T, R]`` int32: what blocked each move, see ``BatchOutcome``; people have
            the numbers from ``R`` on. () for a single robot.
        step_seconds: ``[T, R]`` float64: duration of each motion; () for a single robot.
        step_joules: ``[T, R]`` float64: energy of each motion; () for a single robot.
        orders: Released orders, each with its pickup and delivery so far.
        assignments: Calls of ``FleetEnv.assign``: number of steps taken before the call, robot,
            and order or ``None``.
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
    drive: str = ""
    people: Column = ()
    headings: Column = ()
    stopped_by: Column = ()
    step_seconds: Column = ()
    step_joules: Column = ()
    orders: list[Order] = field(default_factory=list)
    assignments: list[tuple[int, int, int | None]] = field(default_factory=list)
    measures: FleetMeasures = NOT_MEASURED

    _repr_html_ = display  # called by notebooks

    def __post_init__(self) -> None:
        settings = self.settings
        if isinstance(settings, Settings):
            self.backend, self.cell_size = settings.backend, settings.cell_size
            self.slippery, self.motor_strength = settings.slippery, settings.motor_strength
            self.drive = settings.drive

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
        """Whether this is the record of a ``FleetEnv``, with an axis for the robots."""
        return isinstance(self.settings, FleetSettings)

    @property
    def is_driven(self) -> bool:
        """Whether the robot was controlled continuously; its actions are then texts of numbers."""
        return is_drive(self.backend)

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
        """The duration of all motions of a single robot, in seconds; or ``step_seconds``."""
        return self.step_seconds if self.is_fleet else math.fsum(m.seconds for m in self.motions)

    @property
    def joules(self) -> Any:
        """The energy of all motions of a single robot, in joules; or ``step_joules``."""
        return self.step_joules if self.is_fleet else math.fsum(m.joules for m in self.motions)

    @property
    def outcome(self) -> str:
        """The ending in words; for a fleet the number of items delivered.

        A delivery with the last battery unit counts as a delivery.
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

    def counted_actions(self, steps: int | slice = slice(None)) -> NDArray[np.integer]:
        """Return the move that each action of a fleet amounts to; see ``world/moves.py``.

        Args:
            steps: the number of a step, or a slice; default: all steps.

        Returns:
            Indices into ``ACTIONS``, or ``INVALID``. They have the shape ``[R]`` for one step and
            ``[T, R]`` for several.
        """
        actions: NDArray[np.integer] = self.actions[steps]
        if not self.settings.has_headings:
            return actions
        known = np.minimum(actions, len(TURN_ACTIONS) - 1)
        return np.where(actions == INVALID, INVALID, COUNTS_AS[self.headings[:-1][steps], known])

    @property
    def frames(self) -> list[GridFrame]:
        """``[F]`` frames as new lists, in the format of ``WarehouseEnv.render_grid``.

        Frames of a fleet show all robots and people.
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
        """The chapter's four lists for one robot, one entry per frame; empty for several robots.

        Distances are NaN without a station. With orders, the stations change, so the distances are
        left out.
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
        """Write the record to a ``.npz`` file, either completely or not at all.

        Raises:
            RecordError: the record is larger than ``npz.MAX_BYTES``, has more than
                ``arrays.MAX_OBJECTS`` motions and other objects, or could not be loaded unchanged.
                Records of many robots are large because of their paths; setting ``motions`` to an
                empty list makes them small.
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
            raise RecordError(f"{path}: {changed} would change its values or types when loaded")
        write_arrays(path, arrays, schema_of(arrays))

    @staticmethod
    def load(path: str | Path) -> Episode:
        """Read a record from a ``.npz`` file that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or is not a record; the message says what is wrong.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, *SCHEMAS)
        try:
            return Episode(**unpack(arrays))
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error

    def _differences(self, other: Episode) -> Iterator[str]:
        """Yield the names of the fields in which another record differs."""
        for name in self.__slots__:
            if not is_equal(getattr(self, name), getattr(other, name)):
                yield name

    def _bodies(self) -> Iterator[Iterator[tuple[Cell, str]]]:
        """Yield for each frame the cells of the robots and people, each with its character."""
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


def is_drive(backend: str) -> bool:
    """Return whether the name of a backend, with or without settings, means continuous control."""
    return backend.partition(":")[0] == DRIVE


def _distances(cells: Sequence[Cell], stations: Sequence[Cell]) -> list[float]:
    """Return the Manhattan distance from each cell to the first station."""
    if not stations:
        return [math.nan] * len(cells)
    return [float(manhattan_distance(cell, stations[0])) for cell in cells]


FleetEpisode = Episode
