"""Episodes as arrays, many of which run side by side in a ``BatchEnv``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import Any, NamedTuple, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from agents.errors import AgentError, EpisodeError, reason_of
from agents.lab.trials.task import Task
from agents.registry import agent_file, is_own_code, make_agent
from warehouse_core import Agent, BatchEnv, Layout
from warehouse_core.fleet.observation import observation_of
from warehouse_core.gymnasium_env import ID
from warehouse_core.task.encoding import FleetArrays, ObservationArrays, vector
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS, INVALID, WAIT, action_index
from warehouse_core.world.tables import Flags

ROWS = 256
"""Maximum number of episodes that run side by side."""

MAX_BYTES = 2**28
"""Memory for unfinished episodes in bytes, which limits the number of rows."""

OF_STEPS = ("actions", "rewards", "terminations", "truncations")
"""Names of arrays with an element for each step; other arrays have another one for the start."""

MOTION = ("blocked", "seconds", "joules")
"""Names of the columns of ``infos/motion``."""

FIELDS = {
    "observations": "observation as a vector, see warehouse_core.task.vector",
    "actions": f"index of the action: {', '.join(ACTIONS)}",
    "rewards": "reward of the step",
    "terminations": "whether the step delivered the item",
    "truncations": "whether the steps or the battery ran out",
    "infos/action_mask": "1 for each action that has an effect",
    "infos/motion": "whether the robot was blocked, and seconds and joules of its move",
}
"""Description of each array."""


class EpisodeArrays(NamedTuple):
    """An episode of ``T`` steps as arrays with the names that Minari uses in files.

    Attributes:
        seed: seed of the environment and the agent.
        arrays: ``observations`` ``[T + 1, ...]`` float32 from the start to the end, ``actions``
            ``[T, ...]`` int64, ``rewards`` ``[T]`` float64, ``terminations`` and ``truncations``
            ``[T]`` bool, and ``infos/NAME`` ``[T + 1, ...]``, whose first element describes the
            state before any step.
    """

    seed: int
    arrays: dict[str, NDArray[Any]]

    @property
    def steps(self) -> int:
        """Number of steps, ``T``."""
        return len(self.arrays["rewards"])


class Source:
    """A source of episodes of an agent that controls a lone robot.

    An episode is the same as in ``Warehouse-v0`` after a reset with its seed. The agent has the
    same seed.

    Args:
        agent: name of the agent, see ``agents/registry.py``.
        task: task in a single layout, on an installed motion backend.
    """

    def __init__(self, agent: str = "greedy", task: Task = Task()) -> None:  # noqa: B008
        assert isinstance(task.layout, Layout), "a dataset has a single layout"
        self.agent, self.layout, self._arguments = agent, task.layout, task._asdict()
        with closing(gymnasium.make(ID, observation="vector", **self._arguments)) as env:
            self.observation_space, self.action_space = env.observation_space, env.action_space
            self.spec = env.spec
        self.task = f"Agent {agent} delivers an item to its dropoff on the backend {task.backend}."
        low = cast("spaces.Box[Any]", self.observation_space).low
        most = MAX_BYTES // (low.nbytes * task.max_steps)
        # A user's agent may use the global random generators of Python or NumPy, which only one
        # episode at a time may use.
        self._rows = 1 if is_own_code(agent) else int(np.clip(most, 1, ROWS))

    def episodes(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield a complete episode for each seed, in order.

        Raises:
            EpisodeError: the agent raised an exception or returned an invalid action.
        """
        for first in range(0, len(seeds), self._rows):
            yield from self._together(seeds[first : first + self._rows])

    def _together(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield the episodes of some seeds, which run side by side until the longest one ends."""
        agents = [make_agent(self.agent, seed, self.layout) for seed in seeds]
        for agent in agents:
            agent.reset()
        lengths, over = np.zeros(len(seeds), np.intp), np.zeros(len(seeds), np.bool_)
        steps: list[dict[str, NDArray[Any]]] = []
        with closing(BatchEnv(len(seeds), **self._arguments)) as env:
            observed, info = env.reset([*seeds])
            moments = [_moment(observed, info)]
            while not over.all():
                actions = self._actions(agents, observed, ~over, seeds, len(moments))
                observed, rewards, terminated, truncated, info = env.step(actions)
                moments.append(_moment(observed, info))
                steps.append(
                    dict(zip(OF_STEPS, (actions, rewards, terminated, truncated), strict=True))
                )
                lengths[~over] += 1
                over |= terminated | truncated
        arrays = {name: np.stack([each[name] for each in steps], axis=1) for name in OF_STEPS}
        of_moments = {name: np.stack([m[name] for m in moments], axis=1) for name in moments[0]}
        for row, (seed, length) in enumerate(zip(seeds, lengths.tolist(), strict=True)):
            found = {name: values[row, : length + 1].copy() for name, values in of_moments.items()}
            found |= {name: values[row, :length].copy() for name, values in arrays.items()}
            yield EpisodeArrays(seed, found)

    def _actions(
        self, agents: list[Agent], observed: ObservationArrays, acts: Flags, seeds: Sequence[int],
        step: int,
    ) -> NDArray[np.intp]:  # fmt: skip
        """Return the actions of a step; finished rows wait, and their steps are not recorded."""
        actions = np.full(len(agents), WAIT)
        for row in np.flatnonzero(acts).tolist():
            seen = observation_of(cast(FleetArrays, observed), row)
            try:
                actions[row] = _recorded(agents[row].act(seen))
            except (Exception, SystemExit) as error:  # a user's agent may raise anything
                reason = reason_of(error, agent_file(self.agent))
                where = f"seed {seeds[row]}, step {step}, agent {self.agent}"
                raise EpisodeError(f"{where}: {reason}") from error
        return actions


def _recorded(action: Any) -> int:
    """Return the index of an action.

    In the chapter an invalid action costs a step, but the action space of a dataset does not
    contain it.

    Raises:
        AgentError: the action is invalid.
    """
    index = action_index(action)
    if index == INVALID:
        raise AgentError(
            f"the action is {brief(action)}; allowed in a dataset: {', '.join(ACTIONS)}"
        )
    return index


def _moment(observed: ObservationArrays, info: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Return the arrays to record after a reset or a step, with a row for each episode.

    After a reset, ``infos/motion`` is 0, because nothing has moved.
    """
    seen = vector(observed)
    motion = np.zeros((len(seen), len(MOTION)))
    if "motion" in info:
        motion[:] = np.transpose([info["motion"][name] for name in MOTION])
    return {
        "observations": seen, "infos/action_mask": info["action_mask"], "infos/motion": motion,
    }  # fmt: skip
