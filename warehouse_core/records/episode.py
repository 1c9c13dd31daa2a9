"""The record of an episode: enough to draw it, to measure it and to run it again bit for bit.

``T`` is the number of steps and ``F = T + 1`` of frames; frame 0 is the state after ``reset``. The
file format is in ``episode_arrays.py`` and ``files/npz.py``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, SupportsIndex

from warehouse_core.errors import RecordError
from warehouse_core.files.npz import read_arrays, write_arrays
from warehouse_core.motion.backends import Backend
from warehouse_core.motion.base import Outcome
from warehouse_core.records.episode_arrays import EPISODE_SCHEMA, pack_fields, unpack_fields
from warehouse_core.task.settings import Settings
from warehouse_core.task.state import Observation
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.wording import counted
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED, Cell, manhattan_distance

DELIVERED = "delivered"
BATTERY_DEPLETED = "battery depleted"
OUT_OF_TIME = "out of time"
UNFINISHED = "unfinished"

Action = str | int
Frame = list[list[str]]


class Agent(Protocol):
    """What ``record_episode`` needs of an agent.

    An agent may also have an attribute ``reason``, a string that explains its last action; the
    record keeps it.
    """

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, observation: Observation) -> str | SupportsIndex:
        """Return the next action, a word of ``WarehouseEnv.ACTIONS`` or its index."""


@dataclass(slots=True)
class Episode:
    """The record of one episode. Two records are equal when every value in them is.

    Attributes:
        layout: walls and stations during the episode.
        settings: of the environment.
        seed: given to ``reset``, or ``None``.
        agent: a name for the agent.
        cells: ``[F]`` where the robot was.
        loaded: ``[F]`` whether it held an item.
        battery: ``[F]`` units left.
        rewards: ``[F]`` reward of the step before the frame; the first is 0.
        actions: ``[T]`` as the agent gave them.
        reasons: ``[T]`` the agent's reasons, or "".
        motions: ``[T]`` outcomes of the motion backend.
        terminated: the item was delivered.
        truncated: the battery or the steps ran out.
    """

    layout: Layout
    settings: Settings
    seed: int | None
    agent: str
    cells: list[Cell] = field(default_factory=list)
    loaded: list[bool] = field(default_factory=list)
    battery: list[int] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    motions: list[Outcome] = field(default_factory=list)
    terminated: bool = False
    truncated: bool = False

    def __repr__(self) -> str:
        result = f"{self.outcome}, {counted(self.steps, 'step')}, reward {self.total_reward:.2f}"
        return f"<Episode {result}, seed {self.seed}, agent {self.agent!r}>"

    @property
    def steps(self) -> int:
        """``T``, the length of the episode."""
        return len(self.actions)

    @property
    def total_reward(self) -> float:
        """The sum of all rewards, rounded to nine decimals: 14.6, not 14.600000000000001."""
        return round(math.fsum(self.rewards), 9)

    @property
    def seconds(self) -> float:
        """The simulated time that all motions took."""
        return math.fsum(motion.seconds for motion in self.motions)

    @property
    def joules(self) -> float:
        """The energy that all motions cost."""
        return math.fsum(motion.joules for motion in self.motions)

    @property
    def outcome(self) -> str:
        """The outcome; a delivery with the last battery unit is a delivery."""
        if self.terminated:
            return DELIVERED
        if self.battery and self.battery[-1] <= 0:
            return BATTERY_DEPLETED
        return OUT_OF_TIME if self.truncated else UNFINISHED

    @property
    def frames(self) -> list[Frame]:
        """``[F]`` frames as ``WarehouseEnv.render_grid`` returned them, as new lists."""
        frames = []
        for (row, col), loaded in zip(self.cells, self.loaded, strict=True):
            frame = [list(line) for line in self.layout.rows]
            frame[row][col] = ROBOT_LOADED if loaded else ROBOT_EMPTY
            frames.append(frame)
        return frames

    @property
    def metrics(self) -> dict[str, list[float]]:
        """The chapter's four lists, one entry a frame; distances are NaN without a station."""
        return {
            "rewards": list(self.rewards),
            "battery": [float(units) for units in self.battery],
            "dist_pickup": self._distances(self.layout.pickups),
            "dist_dropoff": self._distances(self.layout.dropoffs),
        }

    def _distances(self, stations: Sequence[Cell]) -> list[float]:
        """Return ``[F]`` distances to the first of the stations."""
        if not stations:
            return [math.nan] * len(self.cells)
        return [float(manhattan_distance(cell, stations[0])) for cell in self.cells]

    def save(self, path: str | Path) -> None:
        """Write the record to a ``.npz`` file, whole or not at all.

        Raises:
            RecordError: it is larger than ``npz.MAX_BYTES``, or ``load`` would not return it.
            OSError: the file cannot be written.
        """
        try:
            arrays = pack_fields({name: getattr(self, name) for name in self.__slots__})
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error
        write_arrays(path, arrays, EPISODE_SCHEMA)

    @staticmethod
    def load(path: str | Path) -> Episode:
        """Read a record from a ``.npz`` file that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or no record; the message names what is wrong.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, EPISODE_SCHEMA)
        try:
            return Episode(**unpack_fields(arrays))
        except ValueError as error:
            raise RecordError(f"{path}: {error}") from error


class EpisodeRecorder:
    """Steps an environment and records it; for environments that are driven by hand.

    It starts from the current state of the environment, which should be that after ``reset``.

    Attributes:
        episode: the record so far.
    """

    def __init__(self, env: WarehouseEnv, *, seed: int | None = None, agent: str = "") -> None:
        self._env = env
        self.episode = Episode(env.layout, env.settings, seed, agent)
        self._is_acting = False
        self._keep_frame(0.0)

    @property
    def place(self) -> str:
        """Where ``run`` is, in words: ``"reset"``, or the step such as ``"step 3"``."""
        return f"step {self.episode.steps + 1}" if self._is_acting else "reset"

    @property
    def ended(self) -> bool:
        """Whether the episode is over."""
        return self.episode.terminated or self.episode.truncated

    def step(self, action: str | SupportsIndex, reason: str = "") -> Observation:
        """Take one step and record it."""
        observation, reward, terminated, truncated, _ = self._env.step(action)
        motion = self._env.last_motion
        assert motion is not None, "a step always leaves a motion"
        episode = self.episode
        episode.actions.append(str(action) if isinstance(action, str) else int(action))
        episode.reasons.append(reason)
        episode.motions.append(motion)
        episode.terminated, episode.truncated = terminated, truncated
        self._keep_frame(reward)
        return observation

    def run(self, agent: Agent, observation: Observation) -> None:
        """Reset an agent and let it act until the episode is over.

        Args:
            agent: see ``Agent``.
            observation: the present one.
        """
        agent.reset()
        self._is_acting = True
        while not self.ended:
            action = agent.act(observation)
            observation = self.step(action, reason=str(getattr(agent, "reason", "")))

    def _keep_frame(self, reward: float) -> None:
        state, episode = self._env.state, self.episode
        episode.cells.append(state.robot_pos)
        episode.loaded.append(state.has_item)
        episode.battery.append(state.battery)
        episode.rewards.append(reward)


def record_episode(
    env: WarehouseEnv, agent: Agent, *, seed: int | None = None, randomize: bool | str = True
) -> Episode:
    """Reset the environment and the agent, and run one whole episode.

    Args:
        env: any environment, with any backend.
        agent: see ``Agent``.
        seed: given to ``env.reset``, not to the agent.
        randomize: given to ``env.reset``.

    Returns:
        The record, which ends with the delivery or when the steps or the battery run out.
    """
    observation = env.reset(randomize=randomize, seed=seed)
    recorder = EpisodeRecorder(env, seed=seed, agent=type(agent).__name__)
    recorder.run(agent, observation)
    return recorder.episode


def replay_episode(episode: Episode, backend: Backend | None = None) -> Episode:
    """Run the actions of a record again in a fresh environment.

    With the same backend the result equals the record bit for bit.

    Args:
        episode: the record.
        backend: used instead of the recorded one.
    """
    settings = episode.settings
    env = WarehouseEnv(
        episode.layout,
        settings.start_pos,
        settings.max_steps,
        settings.battery,
        settings.view_radius,
        backend=settings.backend if backend is None else backend,
    )
    env.reset_to(episode.layout, episode.cells[0], episode.seed)
    recorder = EpisodeRecorder(env, seed=episode.seed, agent=episode.agent)
    for action, reason in zip(episode.actions, episode.reasons, strict=True):
        recorder.step(action, reason)
    env.close()
    return recorder.episode
