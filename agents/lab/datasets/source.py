"""Episodes as arrays, many side by side in a ``BatchEnv``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import Any, NamedTuple, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from agents.errors import AgentError, EpisodeError, reason_of
from agents.lab.place import Place
from agents.registry import agent_file, is_own_code, make_agent
from warehouse_core import DEFAULT_LAYOUT, Agent, BatchEnv
from warehouse_core.fleet.observation import observation_of
from warehouse_core.gymnasium_env import ID
from warehouse_core.task.encoding import FleetArrays, ObservationArrays, vector
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS, INVALID, WAIT, action_index
from warehouse_core.world.tables import Flags

ROWS = 256
"""Most episodes side by side."""

MAX_BYTES = 2**28
"""Memory for unfinished episodes, which bounds the number of rows."""

OF_STEPS = ("actions", "rewards", "terminations", "truncations")
"""Names of the arrays that have an element for each step; others have one more, for the start."""

MOTION = ("blocked", "seconds", "joules")
"""Names of the columns of ``infos/motion``."""

FIELDS = {
    "observations": "what the robot observes: warehouse_core.task.vector",
    "actions": f"index of the action: {', '.join(ACTIONS)}",
    "rewards": "reward of the step",
    "terminations": "whether the step delivered the item",
    "truncations": "whether steps or battery were used up",
    "infos/action_mask": "1 for each action that has an effect",
    "infos/motion": "whether something stopped the robot, seconds and joules of the move",
}
"""Meaning of each array."""


class EpisodeArrays(NamedTuple):
    """An episode of ``T`` steps as arrays, by the names that they have in a file of Minari.

    Attributes:
        seed: seed of the environment and of the agent.
        arrays: ``observations`` ``[T + 1, ...]`` float32, from the start to the end; of the steps
            ``actions`` ``[T, ...]`` int64, ``rewards`` ``[T]`` float64, ``terminations`` and
            ``truncations`` ``[T]`` bool; and ``infos/NAME`` ``[T + 1, ...]``, whose first element
            is from before any step.
    """

    seed: int
    arrays: dict[str, NDArray[Any]]

    @property
    def steps(self) -> int:
        """The number of steps, ``T``."""
        return len(self.arrays["rewards"])


class Source:
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

    def episodes(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield one whole episode for each seed, in order.

        Raises:
            EpisodeError: the agent raised an exception, or its action does not exist.
        """
        for first in range(0, len(seeds), self._rows):
            yield from self._together(seeds[first : first + self._rows])

    def _together(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield the episodes of some seeds, which run side by side until the longest has ended."""
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
        """Return the actions of a step; rows that have ended wait and are not recorded."""
        actions = np.full(len(agents), WAIT)
        for row in np.flatnonzero(acts).tolist():
            seen = observation_of(cast(FleetArrays, observed), row)
            try:
                actions[row] = _recorded(agents[row].act(seen))
            except (Exception, SystemExit) as error:  # an agent may raise anything
                reason = reason_of(error, agent_file(self.agent))
                where = f"seed {seeds[row]}, step {step}, agent {self.agent}"
                raise EpisodeError(f"{where}: {reason}") from error
        return actions


def _recorded(action: Any) -> int:
    """Return the index of an action; one that does not exist is an ``AgentError``.

    The chapter lets it cost a step, but the action space of a dataset has no place for it.
    """
    index = action_index(action)
    if index == INVALID:
        raise AgentError(f"the action is {brief(action)}; a dataset takes {', '.join(ACTIONS)}")
    return index


def _moment(observed: ObservationArrays, info: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Return what is recorded of a moment, a row for each episode.

    A reset has no motion: nothing is blocked, and takes neither time nor energy.
    """
    seen = vector(observed)
    motion = np.zeros((len(seen), len(MOTION)))
    if "motion" in info:
        motion[:] = np.transpose([info["motion"][name] for name in MOTION])
    return {
        "observations": seen, "infos/action_mask": info["action_mask"], "infos/motion": motion,
    }  # fmt: skip
