"""Functions and classes that record and replay episodes of one robot or of a fleet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import fields, replace
from importlib import import_module
from typing import Any, Protocol, SupportsIndex

import numpy as np

from warehouse_core.arguments import MAX_SEED, instance_of, whole_number, with_methods
from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.errors import BackendError, EndedError
from warehouse_core.extras import not_installed
from warehouse_core.fleet.env import Actions, FleetEnv
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import Outcome, with_defaults
from warehouse_core.motion.grid import GridMotion
from warehouse_core.records.arrays import FIELD_OF, HEADED_COLUMNS
from warehouse_core.records.episode import Episode
from warehouse_core.task.state import Observation
from warehouse_core.warehouse_env import WarehouseEnv

DRIVE_RECORDS = "warehouse_physics.drive.replay"
"""Module that replays continuous control."""

NO_PATHS = ("grid", GridMotion.__name__)
"""Backends whose robots drive straight from cell to cell, so that the record needs no paths."""

OF_FRAMES = ("cells", "loaded", "battery", "people")
OF_STEPS = ("rewards", "actions", "stopped_by", "seconds", "joules")
"""Arrays of a fleet with one row per frame, and with one row per step."""

OUT_OF_TURN = (
    "the environment was reset, stepped or given another layout between two recorded steps; an "
    "agent acts only with the action that act() returns"
)

HEADINGS_TOO = ("headings",)
"""Additional array, with one row per frame, of a fleet with headings."""


class Agent(Protocol):
    """Protocol of an agent that controls a single robot, as ``record_episode`` requires it.

    If an agent has an attribute ``reason``, the record keeps it as the reason of the last action.

    Example:
        >>> from warehouse_core import Agent, WarehouseEnv, record_episode
        >>> class East:
        ...     def reset(self):
        ...         pass
        ...
        ...     def act(self, observation):
        ...         return "E"
        >>> agent: Agent = East()
        >>> record_episode(WarehouseEnv(max_steps=5), agent).outcome
        'out of time'
    """

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, observation: Observation) -> str | SupportsIndex:
        """Return the next action: a word of ``WarehouseEnv.ACTIONS``, or its index."""


class FleetAgent(Protocol):
    """Protocol of an agent that controls all robots of a fleet, as ``record_episode`` requires it.

    If an agent has an attribute ``reason``, with one reason for all robots or one for each, the
    record keeps it.

    Example:
        >>> from warehouse_core import FleetEnv, record_episode
        >>> from warehouse_core.records import FleetAgent
        >>> class Waiting:
        ...     def reset(self):
        ...         pass
        ...
        ...     def act(self, env):
        ...         return ["WAIT"] * len(env.cells)
        >>> agent: FleetAgent = Waiting()
        >>> record_episode(FleetEnv(robots=2, max_steps=5), agent).steps
        5
    """

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, env: FleetEnv) -> Actions:
        """Return the next action of each robot, in the format of ``FleetEnv.step``.

        Args:
            env: Fleet to inspect. The agent may ``assign`` orders, but must not call ``step``.
        """


class Controller(Protocol):
    """Protocol of an agent of another environment, such as one with continuous control."""

    def reset(self) -> None:
        """Forget the last episode."""

    def act(self, observation: Any) -> Any:
        """Return the next action of the environment."""


class Recordable(Protocol):
    """Protocol of an environment of another package that makes its own recorders."""

    def start_recording(self, *, seed: int | None, agent: str, randomize: bool | str) -> Any:
        """Reset, and return a recorder of the new episode; see ``start_recording``."""


def explanation_of(agent: Agent | FleetAgent | Controller) -> str | Sequence[str]:
    """Return the ``reason`` of an agent that has one, and ``""`` for any other agent."""
    reason: str | Sequence[str] = getattr(agent, "reason", "")
    return reason


class EpisodeRecorder:
    """A recorder that steps a ``WarehouseEnv``, for callers that choose each action themselves.

    It starts from the present state of the environment, which should be the state after ``reset``.

    Args:
        env: Environment with any backend.
        seed: Seed that was given to ``reset``.
        agent: Name of the agent.

    Attributes:
        episode: The record so far.

    Example:
        >>> from warehouse_core import EpisodeRecorder, WarehouseEnv
        >>> env = WarehouseEnv()
        >>> observation = env.reset()
        >>> recorder = EpisodeRecorder(env)
        >>> step = recorder.step("E")
        >>> recorder.episode.steps
        1
    """

    def __init__(self, env: WarehouseEnv, *, seed: int | None = None, agent: str = "") -> None:
        self._env = instance_of("env", env, WarehouseEnv)
        # Records of earlier versions may have negative seeds.
        seed = None if seed is None else whole_number("seed", seed)
        instance_of("agent", agent, str)
        self.episode = Episode(env.layout, env.settings, seed, agent)
        self._is_acting = False
        self._state = env.state
        self._keep_frame(0.0)

    @property
    def place(self) -> str:
        """The present position of ``run``: ``"reset"``, or the step, such as ``"step 3"``."""
        return f"step {self.episode.steps + 1}" if self._is_acting else "reset"

    @property
    def ended(self) -> bool:
        """Whether the episode is over."""
        ended: bool = self.episode.terminated or self.episode.truncated
        return ended

    def step(self, action: str | SupportsIndex, reason: str = "") -> Observation:
        """Take one step and record it.

        Raises:
            EndedError: the environment was reset, stepped or given another layout since the last
                recorded frame.
        """
        env, episode = self._env, self.episode
        is_same = env.state is self._state and env.layout is episode.layout
        if not is_same or env.state.steps != self._steps:
            raise EndedError(OUT_OF_TURN)
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

    def run(self, agent: Agent) -> None:
        """Reset an agent and let it act until the episode is over."""
        agent.reset()
        self._is_acting = True
        observation = self._env.observe()
        while not self.ended:
            action = agent.act(observation)
            observation = self.step(action, reason=str(explanation_of(agent)))

    def _keep_frame(self, reward: float) -> None:
        state, episode = self._env.state, self.episode
        self._steps = state.steps
        episode.cells.append(state.robot_pos)
        episode.loaded.append(state.has_item)
        episode.battery.append(state.battery)
        episode.rewards.append(reward)


class FleetRecorder:
    """A recorder that resets and steps a ``FleetEnv``, for callers that choose the actions.

    Args:
        env: Fleet with any backend.
        seed: Seed for ``reset``; ``None`` chooses one at random.
        agent: Name of the agent.

    Attributes:
        ended: ``True`` once the episode of every robot is over.
        place: Present position of ``run``: ``"reset"``, or the step, such as ``"step 3"``.

    Example:
        >>> from warehouse_core import FleetEnv
        >>> from warehouse_core.records import FleetRecorder
        >>> recorder = FleetRecorder(FleetEnv(robots=2), seed=1)
        >>> step = recorder.step(["E", "WAIT"])
        >>> recorder.episode.robots
        2
    """

    def __init__(self, env: FleetEnv, *, seed: int | None = None, agent: str = "") -> None:
        self._env = instance_of("env", env, FleetEnv)
        self._agent = instance_of("agent", agent, str)
        random = int(np.random.default_rng().integers(2**32))
        self._seed = random if seed is None else whole_number("seed", seed, 0, MAX_SEED)
        self._settings = FleetSettings.from_json(env.settings.to_json())
        self._of_frames = OF_FRAMES + HEADINGS_TOO * env.settings.has_headings
        self._columns: dict[str, list[Any]] = {name: [] for name in (*self._of_frames, *OF_STEPS)}
        self._reasons: list[tuple[str, ...]] = []
        self._motions: list[tuple[Outcome, ...]] = []
        self._terminated = self._truncated = np.zeros(env.settings.robots, np.bool_)
        self.ended, self.place = False, "reset"
        env.reset(seed=self._seed)
        self._assignments = env.assignments
        self._keep_frame()

    def step(self, actions: Actions, reason: Any = "") -> None:
        """Take one step and record it.

        Args:
            actions: Action of each robot; see ``FleetEnv.step``.
            reason: One reason for all actions, or a list or tuple with a reason for each robot.

        Raises:
            EndedError: the environment was reset or stepped since the last recorded frame.
        """
        step, robots = self._env.steps, self._env.settings.robots
        # Each reset begins a new list of assignments.
        if self._env.assignments is not self._assignments or step != len(self._reasons):
            raise EndedError(OUT_OF_TURN)
        chosen = self._env.action_indices(actions)
        _, rewards, terminated, truncated, info = self._env.step(chosen)
        is_each = isinstance(reason, (list, tuple)) and len(reason) == robots
        self._reasons.append(tuple(map(str, reason)) if is_each else (str(reason),) * robots)
        values = {"actions": chosen, "rewards": rewards, **info["motion"]}
        for name in OF_STEPS:
            self._columns[name].append(values[name])
        if self._env.backend not in NO_PATHS:
            self._motions.append(tuple(self._env.last_motion))
        self._terminated, self._truncated = terminated, truncated
        self.ended = bool((terminated | truncated).all())
        self._keep_frame()

    def run(self, agent: FleetAgent) -> None:
        """Reset an agent and let it act until the episode is over."""
        agent.reset()
        while not self.ended:
            self.place = f"step {self._env.steps + 1}"
            self.step(agent.act(self._env), explanation_of(agent))

    @property
    def episode(self) -> Episode:
        """The record so far."""
        env, arrays = self._env, dict[str, Any]()
        for name, rows in self._columns.items():
            bodies = len(env.people) if name == "people" else env.settings.robots
            array = np.array(rows, HEADED_COLUMNS[name][0]).reshape(len(rows), bodies)
            arrays[FIELD_OF.get(name, name)] = array
        return Episode(
            env.layout,
            self._settings,
            self._seed,
            self._agent,
            **arrays,
            terminated=self._terminated,
            truncated=self._truncated,
            reasons=self._reasons[:] if any(map(any, self._reasons)) else [],
            motions=self._motions[:],
            backend=env.backend,
            cell_size=env.cell_size,
            orders=env.orders,
            assignments=list(env.assignments),
            measures=env.measures,
            **env.conditions._asdict(),
        )

    def _keep_frame(self) -> None:
        env = self._env
        as_arrays = {"cells": env.layout.numbers, "people": env.layout.numbers}
        for name in self._of_frames:
            self._columns[name].append(as_arrays.get(name, np.array)(getattr(env, name)))


def start_recording(
    env: WarehouseEnv | FleetEnv | Recordable,
    *,
    seed: int | None = None,
    agent: str = "",
    randomize: bool | str = True,
) -> EpisodeRecorder | FleetRecorder:
    """Reset an environment and return a recorder of the new episode.

    It has the arguments of ``record_episode``, except that ``agent`` is a name.
    """
    if isinstance(env, FleetEnv):
        return FleetRecorder(env, seed=seed, agent=agent)
    if not isinstance(env, WarehouseEnv) and hasattr(env, "start_recording"):
        recorder: EpisodeRecorder = env.start_recording(seed=seed, agent=agent, randomize=randomize)
        return recorder
    instance_of("env", env, WarehouseEnv)
    assert isinstance(env, WarehouseEnv)
    env.reset(randomize=randomize, seed=seed)
    return EpisodeRecorder(env, seed=seed, agent=agent)


def record_episode(
    env: WarehouseEnv | FleetEnv | Recordable,
    agent: Agent | FleetAgent | Controller,
    *,
    seed: int | None = None,
    randomize: bool | str = True,
) -> Episode:
    """Reset an environment and its agent, and run one whole episode.

    Args:
        env: Environment of a single robot or of a fleet, with any backend.
        agent: ``Agent`` of a single robot, or ``FleetAgent``.
        seed: Seed for ``env.reset``, not for the agent. If the stations are random, the same seed
            gives the same episode whenever the environment is used. For a fleet, ``None`` chooses
            a seed at random.
        randomize: Argument of ``env.reset`` for a single robot.

    Returns:
        The record. It ends with the delivery, with an empty battery or at the step limit; the
        record of a fleet ends when the episode of every robot is over.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> episode.outcome, episode.steps
        ('delivered', 23)
    """
    name = type(with_methods("agent", agent, "reset", "act")).__name__
    recorder: Any = start_recording(env, seed=seed, agent=name, randomize=randomize)
    recorder.run(agent)
    episode: Episode = recorder.episode
    return episode


def replay_episode(episode: Episode, backend: Backend | None = None) -> Episode:
    """Run the actions of a record again in a new environment.

    With the same backend the result equals the record bit for bit. A backend that drives through
    the cells of a plan, such as ``driving``, drives the recorded cells of a lone robot in one go.

    Args:
        episode: Record of a single robot or of a fleet.
        backend: Backend to use instead of the recorded one.

    Raises:
        ValueError: the settings of a fleet do not fit the layout, or an assignment names an order
            that does not exist.
        TypeError: an argument has the wrong type.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode, replay_episode
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> replay_episode(episode) == episode
        True
        >>> round(replay_episode(episode, backend="physics").seconds, 1)
        49.8
        >>> round(replay_episode(episode, backend="driving").seconds, 1)
        32.7
    """
    instance_of("episode", episode, Episode)
    backend = episode.backend if backend is None else backend
    return (_replay_fleet if episode.is_fleet else _replay_alone)(episode, backend)


def _replay_alone(episode: Episode, backend: Backend) -> Episode:
    settings = episode.settings
    if episode.is_driven:
        # Continuous control has no motion backend, and belongs to a package that imports this one.
        try:
            records = import_module(DRIVE_RECORDS)
        except ImportError as error:
            need = "a record of continuous control needs"
            raise BackendError(not_installed(need, error, "physics")) from error
        driven: Episode = records.replay(episode, backend)
        return driven
    motion = make_motion(backend)
    complete = with_defaults(motion)
    if complete.drives_through:
        driven = complete.drive_episode(episode)
        name = backend if isinstance(backend, str) else driven.backend
        return replace(driven, settings=replace(driven.settings, backend=name))
    limits = settings.max_steps, settings.battery, settings.view_radius
    env = WarehouseEnv(episode.layout, settings.start_pos, *limits, backend=backend)
    env.reset_to(episode.layout, episode.cells[0], episode.seed)
    recorder = EpisodeRecorder(env, seed=episode.seed, agent=episode.agent)
    for action, reason in zip(episode.actions, episode.reasons, strict=True):
        recorder.step(action, reason)
    env.close()
    return recorder.episode


def _replay_fleet(episode: Episode, backend: Backend) -> Episode:
    settings = {name.name: getattr(episode.settings, name.name) for name in fields(FleetSettings)}
    env = FleetEnv(episode.layout, backend=backend, **settings)
    recorder = FleetRecorder(env, seed=episode.seed, agent=episode.agent)
    assigned = defaultdict(list)
    for step, robot, order in episode.assignments:
        assigned[step].append((robot, order))
    reasons = episode.reasons or [""] * episode.steps
    for step in range(episode.steps + 1):
        for robot, order in assigned[step]:
            env.assign(robot, order)
        if step < episode.steps:
            recorder.step(episode.actions[step], reasons[step])
    env.close()
    return recorder.episode


record_fleet_episode, replay_fleet_episode = record_episode, replay_episode
