"""One episode of a fleet."""

from __future__ import annotations

from agents.fleet.planned import PlannedFleet
from agents.fleet.team import Team
from agents.lab.console.watch import watched
from warehouse_core import FleetEnv, FleetEpisode
from warehouse_core.records.recorder import FleetAgent, FleetRecorder


def run_shift(env: FleetEnv, agent: FleetAgent, name: str, seed: int) -> FleetEpisode:
    """Run one episode of a fleet, and return its record.

    A step that takes long is reported on standard error.

    Args:
        env: of the fleet.
        agent: to be watched.
        name: of the agent.
        seed: of the episode.

    Raises:
        EpisodeError: the agent raised an exception, or returned something that is no action; the
            message has the seed, the step and, of a ``Team``, the robot.
        EpisodeInterrupted: Ctrl-C was pressed.
    """
    recorder = FleetRecorder(env, seed=seed, agent=name)

    def place() -> str:
        robot = agent.robot if isinstance(agent, Team) else None
        return recorder.place if robot is None else f"{recorder.place}, robot {robot}"

    with watched(place, name, _own_code(agent), lambda: recorder.episode):
        recorder.run(agent)
    return recorder.episode


def _own_code(agent: FleetAgent) -> object:
    """Return the part of an agent that a user may have written."""
    if isinstance(agent, Team):
        return agent.agents[0]
    return agent.planner if isinstance(agent, PlannedFleet) else agent
