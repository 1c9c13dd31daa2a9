"""What datasets are made of: episodes as arrays, of a lone robot or of a fleet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

import numpy as np
from gymnasium import Space
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from agents.errors import AgentError, EpisodeError, reason_of
from agents.registry import agent_file
from warehouse_core import Layout
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS, INVALID, action_index

OF_STEPS = ("actions", "rewards", "terminations", "truncations")
"""Names of the arrays that have an element for each step; others have one more, for the start."""

MOTION = ("blocked", "seconds", "joules")
"""Names of the columns of ``infos/motion``."""

INFO_FIELDS = {
    "infos/action_mask": "1 for each action that has an effect",
    "infos/motion": "whether something stopped the robot, seconds and joules of the move",
}
"""Arrays of infos, and what they mean."""


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


class Source(Protocol):
    """Where the episodes of a dataset come from: an agent in an environment.

    Attributes:
        agent: name of the agent.
        observation_space: space of an observation.
        action_space: space of an action.
        spec: spec from which Gymnasium makes the environment again; ``None`` for a fleet.
        layout: layout of the floor.
        task: the task of the agent, in words.
        fields: meaning of each array, by its name.
    """

    agent: str
    observation_space: Space[Any]
    action_space: Space[Any]
    spec: EnvSpec | None
    layout: Layout
    task: str
    fields: dict[str, str]

    def episodes(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield one whole episode for each seed, in order.

        Raises:
            EpisodeError: the agent raised an exception, or its action does not exist.
        """


def infos_of(info: dict[str, Any], robots: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of ``INFO_FIELDS`` ``[R, ...]``, given the info of a step or of a reset.

    A reset has no motion: nothing is blocked, and takes neither time nor energy.
    """
    motion = np.zeros((robots, len(MOTION)))
    if "motion" in info:
        motion[:] = np.transpose([info["motion"][name] for name in MOTION])
    return {"infos/action_mask": info["action_mask"], "infos/motion": motion}


def recorded_action(action: Any) -> int:
    """Return the index of an action; one that does not exist is an ``AgentError``.

    The chapter lets it cost a step, but the action space of a dataset has no place for it.
    """
    index = action_index(action)
    if index == INVALID:
        raise AgentError(f"the action is {brief(action)}; a dataset takes {', '.join(ACTIONS)}")
    return index


@contextmanager
def acting(agent: str, place: Callable[[], tuple[int, int]]) -> Iterator[None]:
    """Turn what an agent raises into an ``EpisodeError``; ``place`` returns its seed and step."""
    try:
        yield
    except (Exception, SystemExit) as error:  # an agent may raise anything
        seed, step = place()
        reason = reason_of(error, agent_file(agent))
        raise EpisodeError(f"seed {seed}, step {step}, agent {agent}: {reason}") from error
