"""Robots of a fleet each of which is directed by an agent of the chapter."""

from __future__ import annotations

import random
from collections.abc import Sequence

from agents.fleet.pilot import Pilot, Site
from warehouse_core import Agent, FleetEnv
from warehouse_core.arguments import seed_number, sequence_of, with_methods
from warehouse_core.world.actions import WAIT


class Team:
    """Robots each of which is directed by an agent of the chapter, such as ``GreedyAgent``.

    See ``Pilot`` for what the agents observe. A robot that drives on from one step to the next, as
    with a backend that drives through, has no action to choose until it is at rest.

    Args:
        agents: one agent for each robot.
        seed: seed of the moves of robots that are in the way.

    Attributes:
        reason: reasons of the last actions, one for each robot; "" for a robot that drives on.
        robot: robot whose agent is choosing now, or ``None``.

    Example:
        >>> from agents import GreedyAgent
        >>> from agents.fleet import Team
        >>> from warehouse_core import FleetEnv, record_episode, shelf_layout
        >>> env = FleetEnv(shelf_layout(aisle=2), 2, orders=0.1, max_steps=100, seed=1)
        >>> shift = record_episode(env, Team([GreedyAgent(1), GreedyAgent(2)], seed=1), seed=1)
        >>> shift.measures.delivered, shift.measures.orders
        (3, 10)
    """

    def __init__(self, agents: Sequence[Agent], seed: int | None = None) -> None:
        self._seed = seed_number(seed)
        for agent in sequence_of("agents", agents, object):
            with_methods("agents", agent, "reset", "act")
        self.agents = agents
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self.robot: int | None = None
        self.reason = [""] * len(self.agents)
        self._pilots: list[Pilot] = []

    def act(self, env: FleetEnv) -> list[int]:
        """Return the next action of each robot, as an index.

        Raises:
            ValueError: the fleet has another number of robots.
        """
        if not self._pilots:
            site, stream = Site(env), random.Random(self._seed)
            if len(self.agents) != env.settings.robots:
                given = f"{len(self.agents)} agents for {env.settings.robots} robots"
                raise ValueError(f"{given}; each needs one")
            self._pilots = [Pilot(agent, site, stream) for agent in self.agents]
        actions = [WAIT] * len(self.agents)
        self.reason = [""] * len(self.agents)
        at_rest = env.ways.at_rest
        for robot, observation in enumerate(env.observations()):
            self.robot, pilot = robot, self._pilots[robot]
            if at_rest[robot]:
                actions[robot] = pilot.act(observation)
                self.reason[robot] = pilot.reason
        self.robot = None
        return actions
