"""Episodes of a lone robot, many side by side in a ``BatchEnv``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from agents.lab.datasets.source import (
    INFO_FIELDS,
    OF_STEPS,
    EpisodeArrays,
    acting,
    infos_of,
    recorded_action,
)
from agents.lab.place import Place
from agents.registry import is_own_code, make_agent
from warehouse_core import DEFAULT_LAYOUT, Agent, BatchEnv
from warehouse_core.batch.array_env import DISABLED
from warehouse_core.fleet.observation import observation_of
from warehouse_core.gymnasium_env import ID
from warehouse_core.task.encoding import FleetArrays, ObservationArrays, vector
from warehouse_core.world.actions import ACTIONS, WAIT
from warehouse_core.world.tables import Flags, Integers

ROWS = 256
"""Most episodes side by side."""

MAX_BYTES = 2**28
"""Memory for unfinished episodes, which bounds the number of rows."""

FIELDS = {
    "observations": "what the robot observes: warehouse_core.task.vector",
    "actions": f"index of the action: {', '.join(ACTIONS)}",
    "rewards": "reward of the step",
    "terminations": "whether the step delivered the item",
    "truncations": "whether steps or battery were used up",
    **INFO_FIELDS,
}
"""Meaning of each array."""


class LoneSource:
    """Episodes of an agent of a lone robot.

    The episode of a seed is the one of ``Warehouse-v0`` after a reset with it, and the agent has
    the same seed.

    Args:
        agent: name of the agent, see ``agents/registry.py``.
        place: layout and start, and what is drawn.
        backend: name of an installed motion backend.
        battery: units of a full battery.
        max_steps: most steps of an episode.
        view_radius: cells seen in each direction.
    """

    fields = FIELDS

    def __init__(
        self,
        agent: str = "greedy",
        place: Place | None = None,
        backend: str = "grid",
        battery: int = 200,
        max_steps: int = 200,
        view_radius: int = 2,
    ) -> None:
        place = place or Place(DEFAULT_LAYOUT, None, True)
        self.agent, self.layout = agent, place.layout
        arguments: dict[str, Any] = {
            "start_pos": place.start_pos, "max_steps": max_steps, "battery": battery,
            "view_radius": view_radius, "randomize": place.randomize, "backend": backend,
        }  # fmt: skip
        self._arguments = {"layout": place.layout, **arguments}
        with closing(gymnasium.make(ID, observation="vector", **self._arguments)) as env:
            self.observation_space, self.action_space = env.observation_space, env.action_space
            self.spec = env.spec
        self.task = f"Agent {agent} takes an item to its dropoff on the backend {backend}."
        low = cast("spaces.Box[Any]", self.observation_space).low
        most = MAX_BYTES // (low.nbytes * max_steps)
        # An agent of a user may draw from the global random numbers of Python or NumPy, which
        # belong to one episode at a time.
        self._rows = 1 if is_own_code(agent) else int(np.clip(most, 1, ROWS))

    def make_agent(self, seed: int) -> Agent:
        """Return the agent of an episode, ready to act."""
        agent = make_agent(self.agent, seed, self.layout)
        agent.reset()
        return agent

    def episodes(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield one whole episode for each seed, in order; see ``Source``."""
        rows = min(self._rows, len(seeds))
        with closing(BatchEnv(rows, autoreset_mode=DISABLED, **self._arguments)) as env:
            batch, ended = _Rows(env, self, iter(seeds)), dict[int, EpisodeArrays]()
            for seed in seeds:
                while seed not in ended:
                    ended.update((episode.seed, episode) for episode in batch.step())
                yield ended.pop(seed)


class _Rows:
    """The rows of a batch, each with an episode of its own, and the next seed when that ends."""

    def __init__(self, env: BatchEnv, source: LoneSource, seeds: Iterator[int]) -> None:
        self._env, self._source, self._waiting = env, source, seeds
        count = env.num_envs
        self._agents: list[Agent | None] = [None] * count
        self._seeds, self._over = [0] * count, np.ones(count, np.bool_)
        self._rows, self._steps = np.arange(count), np.zeros(count, np.intp)
        self._buffers: dict[str, NDArray[Any]] = {}
        """Records of the episodes so far, ``[B, max_steps + 1, ...]`` for each name."""

    def step(self) -> list[EpisodeArrays]:
        """Carry out one action in each row, and return the episodes that have ended by it."""
        if self._over.any():
            self._begin(self._over)
        actions = self._actions()
        arrays, rewards, terminated, truncated, info = self._env.step(actions)
        for name, values in (
            ("actions", actions), ("rewards", rewards),
            ("terminations", terminated), ("truncations", truncated),
        ):  # fmt: skip
            self._put(name, values, self._rows)
        self._steps += 1
        self._see(self._rows, arrays, info)
        self._over = terminated | truncated
        rows = np.flatnonzero(self._over).tolist()
        return [self._episode(row) for row in rows if self._agents[row] is not None]

    def _begin(self, over: Flags) -> None:
        """Start the episodes of the next seeds; rows without one go on and are not recorded."""
        rows = np.flatnonzero(over)
        for row in rows.tolist():
            seed = next(self._waiting, None)
            self._agents[row] = None if seed is None else self._source.make_agent(seed)
            self._seeds[row] = self._seeds[row] if seed is None else seed
        arrays, info = self._env.reset(self._seeds, None if over.all() else over)
        self._steps[rows] = 0
        self._see(rows, arrays, info)

    def _actions(self) -> NDArray[np.intp]:
        """Return the action of the agent of each row; rows that are not recorded wait."""
        actions = np.full(len(self._agents), WAIT)
        row = 0
        with acting(self._source.agent, lambda: (self._seeds[row], int(self._steps[row]) + 1)):
            for row, agent in enumerate(self._agents):
                if agent is not None:
                    actions[row] = recorded_action(agent.act(observation_of(self._arrays, row)))
        return actions

    def _see(self, rows: Integers, arrays: ObservationArrays, info: dict[str, Any]) -> None:
        """Keep what some rows observe now, and the infos if they are recorded."""
        self._arrays = cast(FleetArrays, arrays)
        seen = {"observations": vector(arrays), **infos_of(info, len(self._agents))}
        for name, values in seen.items():
            self._put(name, values[rows], rows)

    def _put(self, name: str, values: NDArray[Any], rows: Integers) -> None:
        if name not in self._buffers:
            shape = len(self._agents), self._env.max_steps + 1, *values.shape[1:]
            self._buffers[name] = np.zeros(shape, values.dtype)
        self._buffers[name][rows, self._steps[rows]] = values

    def _episode(self, row: int) -> EpisodeArrays:
        """Return a copy of what has been kept of a row."""
        steps = int(self._steps[row])
        lengths = {name: steps if name in OF_STEPS else steps + 1 for name in self._buffers}
        return EpisodeArrays(
            self._seeds[row],
            {name: self._buffers[name][row, :length].copy() for name, length in lengths.items()},
        )
