"""The record of a fleet's episode: enough to draw it, to measure it and to run it again.

``T`` is the number of steps and ``F = T + 1`` of frames, ``R`` of robots and ``P`` of people; frame
0 is the state after ``reset``. The file format is in ``fleet_arrays.py`` and ``files/npz.py``.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.batch.fleet.tally import FleetMeasures
from warehouse_core.errors import RecordError
from warehouse_core.files.npz import read_arrays, write_arrays
from warehouse_core.fleet.env import Actions, FleetEnv
from warehouse_core.motion.backends import Backend
from warehouse_core.motion.base import Outcome
from warehouse_core.motion.grid import GridMotion
from warehouse_core.orders.order import Order
from warehouse_core.records.episode_arrays import pack_checked
from warehouse_core.records.fleet_arrays import (
    END_COLUMNS,
    FLEET_SCHEMA,
    FRAME_COLUMNS,
    STEP_COLUMNS,
    is_equal,
    pack,
    unpack,
)
from warehouse_core.wording import counted
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

NO_PATHS = ("grid", GridMotion.__name__)
"""Backends whose robots drive straight from cell to cell, so that the cells say it all."""


class FleetAgent(Protocol):
    """What ``record_fleet_episode`` needs of an agent that directs all robots of a fleet."""

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, env: FleetEnv) -> Actions:
        """Return the next action of each robot, as ``FleetEnv.step`` takes them.

        Args:
            env: to be looked at and not stepped; ``assign`` gives an order to a robot.
        """


@dataclass(slots=True, eq=False)
class FleetEpisode:
    """The record of one episode of a fleet. Two records are equal when every value in them is.

    Cells are numbers, ``row * W + col``. Arrays are not to be changed.

    Attributes:
        layout: walls, stations and chargers.
        settings: of the fleet.
        backend: its name, or that of its class.
        cell_size: side of a cell in metres.
        seed: given to ``reset``.
        agent: a name for the agent.
        cells: ``[F, R]`` int32, where the robots were.
        loaded: ``[F, R]`` bool, whether they held an item.
        battery: ``[F, R]`` float64 units left.
        people: ``[F, P]`` int32, where the people were.
        rewards: ``[T, R]`` float64.
        actions: ``[T, R]`` int8 indices, ``INVALID`` for those that are not allowed.
        stopped_by: ``[T, R]`` int32, what blocked a move, see ``BatchOutcome``; people have the
            numbers from ``R`` on.
        seconds: ``[T, R]`` float64, duration of each motion.
        joules: ``[T, R]`` float64, cost of each motion.
        terminated: ``[R]`` bool, whether the task of the robot is done.
        truncated: ``[R]`` bool, whether its battery or the steps are used up.
        orders: those released, and what has become of them.
        assignments: by the agent: steps taken before, robot, and order or ``None``.
        measures: of the whole episode.
        motions: ``[T]`` outcomes of the robots and then the people; none for backends whose robots
            drive straight from cell to cell.
        slippery: open cells whose floor the backend says is slippery.
        motor_strength: actual share of the motor force.
    """

    layout: Layout
    settings: FleetSettings
    backend: str
    cell_size: float
    seed: int
    agent: str
    cells: NDArray[np.int32]
    loaded: NDArray[np.bool_]
    battery: NDArray[np.float64]
    people: NDArray[np.int32]
    rewards: NDArray[np.float64]
    actions: NDArray[np.int8]
    stopped_by: NDArray[np.int32]
    seconds: NDArray[np.float64]
    joules: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    orders: list[Order]
    assignments: list[tuple[int, int, int | None]]
    measures: FleetMeasures
    motions: list[tuple[Outcome, ...]] = field(default_factory=list)
    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FleetEpisode):
            return NotImplemented
        return all(is_equal(getattr(self, name), getattr(other, name)) for name in self.__slots__)

    def __repr__(self) -> str:
        result = f"{counted(self.robots, 'robot')}, {self.outcome}, {counted(self.steps, 'step')}"
        return f"<FleetEpisode {result}, seed {self.seed}, agent {self.agent!r}>"

    @property
    def steps(self) -> int:
        """``T``, the length of the episode."""
        return len(self.actions)

    @property
    def robots(self) -> int:
        """``R``, the number of robots."""
        return self.settings.robots

    @property
    def total_reward(self) -> float:
        """The sum of all rewards of all robots, rounded to nine decimals."""
        return round(math.fsum(self.rewards.flat), 9)

    @property
    def outcome(self) -> str:
        """How many items were delivered, in words."""
        delivered, orders = self.measures.delivered, self.settings.orders
        if orders is None:
            return f"{delivered:,} of {counted(self.robots, 'item')} delivered"
        return f"{delivered:,} of {counted(len(self.orders), 'order')} delivered"

    def save(self, path: str | Path) -> None:
        """Write the record to a ``.npz`` file, whole or not at all.

        Raises:
            RecordError: it is larger than ``npz.MAX_BYTES``, which paths of many robots soon are
                (``motions`` may be emptied), or ``load`` would not return it.
            OSError: the file cannot be written.
        """
        values = {name: getattr(self, name) for name in self.__slots__}
        try:
            arrays = pack_checked(values, FLEET_SCHEMA, pack, unpack, is_equal)
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error
        write_arrays(path, arrays, FLEET_SCHEMA)

    @staticmethod
    def load(path: str | Path) -> FleetEpisode:
        """Read a record from a ``.npz`` file that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or no record; the message names what is wrong.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, FLEET_SCHEMA)
        try:
            return FleetEpisode(**unpack(arrays))
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error


class FleetRecorder:
    """Resets a fleet, steps it and records it; for fleets that are driven by hand.

    Args:
        env: any fleet, with any backend.
        seed: given to ``reset``; ``None`` draws one.
        agent: a name for the agent.

    Attributes:
        ended: whether all robots have ended.
        place: where ``run`` is, in words: ``"reset"``, or the step such as ``"step 3"``.
    """

    def __init__(self, env: FleetEnv, *, seed: int | None = None, agent: str = "") -> None:
        self._env, self._agent = env, agent
        self._seed = int(np.random.default_rng().integers(2**32)) if seed is None else int(seed)
        self._settings = FleetSettings.from_json(env.settings.to_json())
        self._frames: dict[str, list[Any]] = {name: [] for name in FRAME_COLUMNS}
        self._steps: dict[str, list[Any]] = {name: [] for name in STEP_COLUMNS}
        self._ends: dict[str, Any] = dict.fromkeys(
            END_COLUMNS, np.zeros(env.settings.robots, np.bool_)
        )
        self._motions: list[tuple[Outcome, ...]] = []
        self.ended, self.place = False, "reset"
        env.reset(seed=self._seed)
        self._keep_frame()

    def step(self, actions: Actions) -> None:
        """Take one step and record it; see ``FleetEnv.step``."""
        chosen = self._env.action_indices(actions)
        _, rewards, terminated, truncated, info = self._env.step(chosen)
        found = {"actions": chosen, "rewards": rewards, **info["motion"]}
        for name, values in self._steps.items():
            values.append(found[name])
        if self._env.backend not in NO_PATHS:
            self._motions.append(tuple(self._env.last_motion))
        self._ends = {"terminated": terminated, "truncated": truncated}
        self.ended = bool((terminated | truncated).all())
        self._keep_frame()

    def run(self, agent: FleetAgent) -> None:
        """Reset an agent and let it act until the episode is over."""
        agent.reset()
        while not self.ended:
            self.place = f"step {self._env.steps + 1}"
            self.step(agent.act(self._env))

    @property
    def episode(self) -> FleetEpisode:
        """The record so far."""
        env = self._env
        steps = self._columns(self._steps, STEP_COLUMNS, env.settings.robots)
        return FleetEpisode(
            env.layout,
            self._settings,
            env.backend,
            env.cell_size,
            self._seed,
            self._agent,
            **self._columns(self._frames, FRAME_COLUMNS),
            **steps,
            **self._ends,
            orders=env.orders,
            assignments=list(env.assignments),
            measures=env.measures,
            motions=list(self._motions),
            **env.conditions._asdict(),
        )

    def _keep_frame(self) -> None:
        env, width = self._env, self._env.layout.width
        for name, values in self._frames.items():
            found = np.array(getattr(env, name))
            if name in ("cells", "people"):
                found = found.reshape(-1, 2) @ [width, 1]
            values.append(found)

    @staticmethod
    def _columns(
        lists: dict[str, list[Any]], types: dict[str, str], robots: int | None = None
    ) -> dict[str, Any]:
        """Return the arrays of some lists of rows; those of no steps have ``robots`` columns."""
        arrays = {name: np.array(rows, types[name]) for name, rows in lists.items()}
        return {
            name: array if len(array) else array.reshape(0, robots or 0)
            for name, array in arrays.items()
        }


def record_fleet_episode(
    env: FleetEnv, agent: FleetAgent, *, seed: int | None = None
) -> FleetEpisode:
    """Reset a fleet and its agent, and run one whole episode.

    Args:
        env: any fleet, with any backend.
        agent: see ``FleetAgent``.
        seed: given to ``env.reset``, not to the agent; ``None`` draws one.

    Returns:
        The record, which ends when all robots have.
    """
    recorder = FleetRecorder(env, seed=seed, agent=type(agent).__name__)
    recorder.run(agent)
    return recorder.episode


def replay_fleet_episode(episode: FleetEpisode, backend: Backend | None = None) -> FleetEpisode:
    """Run the actions of a record again in a fresh fleet.

    With the same backend the result equals the record bit for bit.

    Args:
        episode: the record.
        backend: used instead of the recorded one.

    Raises:
        ValueError: the settings do not fit the layout, or an assignment the orders.
    """
    settings = {name.name: getattr(episode.settings, name.name) for name in fields(FleetSettings)}
    env = FleetEnv(episode.layout, backend=backend or episode.backend, **settings)
    recorder = FleetRecorder(env, seed=episode.seed, agent=episode.agent)
    assigned = defaultdict(list)
    for step, robot, order in episode.assignments:
        assigned[step].append((robot, order))
    for step in range(episode.steps + 1):
        for robot, order in assigned[step]:
            env.assign(robot, order)
        if step < episode.steps:
            recorder.step(episode.actions[step])
    env.close()
    return recorder.episode
