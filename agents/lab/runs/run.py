"""One run: an agent acts in an environment until the episode is over, and everything is recorded.

A lone robot and a fleet are run by the same function.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, cast

from agents.errors import EpisodeError, EpisodeInterrupted, file_of, frames_in, reason_of
from agents.fleet.planned import PlannedFleet
from agents.fleet.team import Team
from warehouse_core import Agent, Episode, FleetEnv, WarehouseEnv
from warehouse_core.records import FleetAgent
from warehouse_core.records.recorder import start_recording

MAX_SEED = 999_999
"""Largest seed that is drawn; it is short enough to type again."""

Whereabouts = Callable[[], str]
"""Tells where an episode is, in words: ``"reset"``, or a step such as ``"step 3"``."""

Watch = Callable[[Whereabouts], AbstractContextManager[object]]
"""Makes the context that an episode runs in; it may report steps that take long."""


def run(
    env: WarehouseEnv | FleetEnv, agent: Agent | FleetAgent, seed: int | None,
    watch: Watch = nullcontext, *, name: str = "", randomize: bool | str = True,
) -> Episode:  # fmt: skip
    """Reset an environment and its agent, run one whole episode, and return its record.

    Args:
        env: environment of a lone robot or of a fleet; it is not closed.
        agent: agent of the robot, or agent that directs the fleet.
        seed: seed of the reset, not of the agent; ``None`` draws one.
        watch: makes the context that the episode runs in.
        name: name of the agent in messages and in the record of a fleet; the default is its class.
            The record of a lone robot always has the class.
        randomize: choice of what a lone robot's reset draws, see ``WarehouseEnv.reset``.

    Raises:
        EpisodeError: the agent or the backend raised an exception, or the agent returned something
            that is no action; the message has the seed, the step and, of a ``Team``, the robot.
        EpisodeInterrupted: Ctrl-C was pressed.
    """
    kind = type(agent).__name__
    name = name or kind
    recorded = name if isinstance(env, FleetEnv) else kind
    recorder: Any = start_recording(env, seed=seed, agent=recorded, randomize=randomize)

    def place() -> str:
        robot = agent.robot if isinstance(agent, Team) else None
        return recorder.place if robot is None else f"{recorder.place}, robot {robot}"

    file = file_of(own_code(agent))
    try:
        with watch(place):
            recorder.run(agent)
    except KeyboardInterrupt as error:
        reason = reason_of(error, file).removeprefix("KeyboardInterrupt")
        message = f"in {place()}, agent {name}{reason}"
        raise EpisodeInterrupted(message, recorder.episode) from error
    except (Exception, SystemExit) as error:  # an agent may raise anything
        episode, moving = recorder.episode, file_of(env.motion)
        culprit = f"agent {name}"
        if moving is not None and frames_in(moving, error):
            culprit, file = f"backend {env.backend}", moving
        message = f"seed {episode.seed}, {place()}, {culprit}: {reason_of(error, file)}"
        raise EpisodeError(message, episode) from error
    return cast(Episode, recorder.episode)


def draw_seed() -> int:
    """Return a random seed."""
    return random.SystemRandom().randint(0, MAX_SEED)


def own_code(agent: object) -> object:
    """Return the part of an agent that a user may have written."""
    if isinstance(agent, Team):
        return agent.agents[0]
    return agent.planner if isinstance(agent, PlannedFleet) else agent
