"""Teams: fleets in which an agent for a single robot controls each robot.

The agents know nothing of orders and chargers. A pilot presents the goals of its robot to each of
them.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np

from agents.fleet.charging import DETOUR, ENOUGH, use_and_charge
from warehouse_core import Agent, Cell, FleetEnv
from warehouse_core.arguments import seed_number, sequence_of, with_methods
from warehouse_core.fleet.observation import FleetObservation
from warehouse_core.records.recorder import explanation_of
from warehouse_core.world.actions import WAIT, action_index
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import (
    MOVE_DELTAS,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    WALL,
    manhattan_distance,
    moved,
)

CLOSED = (WALL, OTHER_EMPTY, OTHER_LOADED, PERSON)
"""Tiles of an observation that no robot can drive into."""

NEARLY_FULL = 0.9
"""Share of a full battery with which a robot leaves its charger, or less if charging slows down."""

SPARE_MOVES = 10
"""Reserve in moves, beyond ``DETOUR`` times the shortest path, with which a robot goes to charge.

The agent may not find the shortest path, and other robots may block it.
"""

PATIENCE = 3
"""Number of failed moves in a row after which a robot makes a random one."""

Goal = tuple[Cell | None, Cell | None]
"""Cells of pickup and dropoff."""


class Site:
    """Knowledge about a warehouse that the robots of a fleet share, made after a reset.

    Attributes:
        stations: cells in which no robot should wait without a reason.
        enough: units above which no robot goes to charge, see ``ENOUGH``.
        full: units with which a robot leaves its charger: ``NEARLY_FULL``, or less if the knee of
            its charging curve is lower.
        free: chargers to which no robot goes.
    """

    def __init__(self, env: FleetEnv) -> None:
        layout, battery = env.layout, env.settings.battery
        self.stations = {*layout.pickups, *layout.dropoffs, *layout.chargers}
        self.enough = ENOUGH * battery.capacity
        knee = battery.capacity - battery.tail
        self.full = max(min(NEARLY_FULL * battery.capacity, knee), self.enough)
        self.free = list(layout.chargers)
        self._distances = distances(layout, layout.chargers)
        self._cost, charge = use_and_charge(env)
        # Robots that start together run low together, so that one may have to queue for others.
        before = max(env.settings.robots / max(len(self.free), 1) - 1, 0)
        trip = (
            DETOUR * float(self._distances[self._distances < np.inf].mean()) if self.free else 0.0
        )
        charging = self.full / charge
        self._spare = SPARE_MOVES + before * (SPARE_MOVES + trip + charging)

    def reserve(self, cell: Cell) -> float:
        """Return the units below which a robot at a cell should go to charge."""
        needed = (DETOUR * float(self._distances[cell]) + self._spare) * self._cost
        return min(needed, self.enough)

    def take_charger(self, cell: Cell) -> Cell | None:
        """Reserve and return the nearest free charger, or ``None``."""
        if not self.free:
            return None
        charger = min(self.free, key=lambda each: manhattan_distance(cell, each))
        self.free.remove(charger)
        return charger


class Pilot:
    """One robot, whose agent observes a separate episode for each goal of the robot.

    The order of the robot gives the cells to pick and to drop in. If the battery is low, a free
    charger takes the place of both, and the robot waits there until its battery is nearly full. A
    robot without an order waits, but not on a station or a charger. After ``PATIENCE`` failed
    moves, it makes a random move. After each action, ``reason`` has the reason for it.
    """

    def __init__(self, agent: Agent, site: Site, stream: random.Random) -> None:
        self._agent, self._site, self._random = agent, site, stream
        self._goal: Goal | None = None
        self._charger: Cell | None = None
        self._before: Cell | None = None
        self._is_low = False
        self._failed = 0
        self.reason = ""

    def act(self, observation: FleetObservation) -> int:
        """Return the next action as an index, and set ``reason``."""
        here = observation["robot_pos"]
        self._failed = self._failed + 1 if here == self._before else 0
        action = self._choose(observation, here)
        self._before = here if action < WAIT else None
        return action

    def _choose(self, observation: FleetObservation, here: Cell) -> int:
        goal = observation["pickup_pos"], observation["dropoff_pos"]
        is_idle = goal == (None, None)
        self._plan_charging(observation["battery"], here, is_idle)
        if observation["battery"] <= 0:
            return self._wait("battery empty")
        if here == self._charger:
            return self._wait("charges")
        if is_idle and self._charger is None:
            if here in self._site.stations:
                return self._step_aside(observation, here, "leaves a station")
            return self._wait("no order")
        if self._failed >= PATIENCE:
            return self._step_aside(observation, here, "gives way")
        return self._ask(observation, (self._charger,) * 2 if self._charger else goal)

    def _plan_charging(self, battery: int, here: Cell, is_idle: bool) -> None:
        """Reserve a charger if the battery is low, and release it otherwise."""
        site = self._site
        enough = site.full if self._is_low else site.enough if is_idle else site.reserve(here)
        self._is_low = 0 < battery < enough
        if self._is_low and self._charger is None:
            self._charger = site.take_charger(here)
        elif not self._is_low and self._charger is not None:
            site.free.append(self._charger)
            self._charger = None

    def _ask(self, observation: FleetObservation, goal: Goal) -> int:
        """Return the agent's action for a goal."""
        has_item, before = observation["has_item"], self._goal
        is_same = goal == before or (has_item and before is not None and goal[1] == before[1])
        if not is_same:
            self._agent.reset()
        self._goal = goal
        pickup, dropoff = goal
        seen: FleetObservation = {**observation, "pickup_pos": pickup, "dropoff_pos": dropoff}
        action = action_index(self._agent.act(seen))
        self.reason = str(explanation_of(self._agent))
        return action

    def _step_aside(self, observation: FleetObservation, here: Cell, reason: str) -> int:
        """Return a random move to a cell that seems free, preferably not a station."""
        self._failed, window = 0, observation["local_grid"]
        centre = len(window) // 2
        free = [
            move
            for move, (down, right) in MOVE_DELTAS.items()
            if centre == 0 or window[centre + down][centre + right] not in CLOSED
        ]
        aside = [move for move in free if moved(here, MOVE_DELTAS[move]) not in self._site.stations]
        if not free:
            return self._wait("shut in")
        self.reason = reason
        return action_index(self._random.choice(aside or free))

    def _wait(self, reason: str) -> int:
        self.reason = reason
        return WAIT


class Team:
    """Fleet agent with one agent for each robot, such as ``GreedyAgent``.

    See ``Pilot`` for what the agents observe. With a backend in which robots drive through, a robot
    that is still moving has no action to choose until it is at rest.

    Args:
        agents: one agent for each robot.
        seed: seed of the random moves of robots that are blocked.

    Attributes:
        reason: reasons of the last actions, one for each robot; "" for a robot that is still
            moving.
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
            ValueError: the number of robots differs from the number of agents.
        """
        if not self._pilots:
            site, stream = Site(env), random.Random(self._seed)
            if len(self.agents) != env.settings.robots:
                given = f"{len(self.agents)} agents for {env.settings.robots} robots"
                raise ValueError(f"{given}; each needs one")
            self._pilots = [Pilot(agent, site, stream) for agent in self.agents]
        actions = [WAIT] * len(self.agents)
        self.reason = [""] * len(self.agents)
        at_rest = env.routes.at_rest
        for robot, observation in enumerate(env.observations()):
            self.robot, pilot = robot, self._pilots[robot]
            if at_rest[robot]:
                actions[robot] = pilot.act(observation)
                self.reason[robot] = pilot.reason
        self.robot = None
        return actions
