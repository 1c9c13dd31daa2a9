"""A run, in which an agent acts in an environment until the episode ends and is recorded.

The same function runs lone robots and fleets.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, cast

from agents.errors import EpisodeError, EpisodeInterrupted, file_of, frames_in, reason_of
from agents.fleet.planned import PlannedFleet
from agents.fleet.team import Team
from agents.learning.drive_policy import DrivePolicy
from warehouse_core import Agent, Episode, FleetEnv, WarehouseEnv
from warehouse_core.records import FleetAgent
from warehouse_core.records.recorder import Controller, Recordable, start_recording

MAX_SEED = 999_999
"""Largest random seed, which is short enough to type again."""

Whereabouts = Callable[[], str]
"""Function that describes where an episode is: ``"reset"``, or a step such as ``"step 3"``."""

Watch = Callable[[Whereabouts], AbstractContextManager[object]]
"""Function that returns the context in which an episode runs; it may report slow steps."""


def run(
    env: WarehouseEnv | FleetEnv | Recordable, agent: Agent | FleetAgent | Controller,
    seed: int | None,
    watch: Watch = nullcontext, *, name: str = "", randomize: bool | str = True,
) -> Episode:  # fmt: skip
    """Reset an environment and its agent, run one episode to its end, and return its record.

    Args:
        env: environment of a lone robot or of a fleet; it is not closed.
        agent: agent of the robot, or agent that controls the fleet.
        seed: seed of the reset, but not of the agent; ``None`` stands for a random seed.
        watch: function that returns the context in which the episode runs.
        name: name of the agent in messages and in the record of a fleet, by default the name of its
            class. The record of a lone robot always has the name of the class.
        randomize: option of a lone robot's ``WarehouseEnv.reset``.

    Raises:
        EpisodeError: the agent or the backend raised an exception, or the agent returned an object
            that is not an action. The message names the seed, the step and, for a ``Team``, the
            robot.
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
            recorder.run(controller_of(env, agent))
    except KeyboardInterrupt as error:
        reason = reason_of(error, file).removeprefix("KeyboardInterrupt")
        message = f"in {place()}, agent {name}{reason}"
        raise EpisodeInterrupted(message, recorder.episode) from error
    except (Exception, SystemExit) as error:  # an agent may raise anything
        episode, moving = recorder.episode, file_of(getattr(env, "motion", None))
        culprit = f"agent {name}"
        if moving is not None and frames_in(moving, error):
            culprit, file = f"backend {recorder.episode.backend}", moving
        message = f"seed {episode.seed}, {place()}, {culprit}: {reason_of(error, file)}"
        raise EpisodeError(message, episode) from error
    return cast(Episode, recorder.episode)


def controller_of(env: Any, agent: Any) -> Any:
    """Return what acts for an agent: a follower if a grid agent is to control a body."""
    if isinstance(env, (WarehouseEnv, FleetEnv)) or isinstance(agent, DrivePolicy):
        return agent
    from agents.drive.follower import Follower  # needs pymunk, as its environment does

    return Follower(env, agent)


def draw_seed() -> int:
    """Return a random seed."""
    return random.SystemRandom().randint(0, MAX_SEED)


def own_code(agent: object) -> object:
    """Return the part of an agent that may be a user's own code."""
    if isinstance(agent, Team):
        return agent.agents[0]
    return agent.planner if isinstance(agent, PlannedFleet) else agent
