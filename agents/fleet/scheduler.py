"""Scheduler of a fleet: gives each robot an order, a charger, or a place out of the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.fleet.charging import QUEUE_DISTANCE, Chargers, Needs
from agents.fleet.detours import Detours
from agents.fleet.escapes import Escapes
from agents.fleet.travel import TravelTimes
from agents.mapf.assignment import ASSIGNMENTS, REASSIGNING, Tasks
from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import FAR, NONE
from agents.mapf.planner import Situation
from warehouse_core import Cell, FleetEnv
from warehouse_core.motion.base import with_defaults
from warehouse_core.world.actions import DISPLACEMENTS, DROP, PICK, WAIT
from warehouse_core.world.distances import nearest
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers

IDLE, BETWEEN, NEAR = 0.9, 0.5, 0.6
"""Battery shares below which a robot goes to an unused charger.

They apply to idle robots, to robots between orders, and to robots near a charger.
"""

MAX_PAIRS, LARGE_EVERY = 40_000, 10
"""Number of pairs of a robot and an order up to which every step reassigns the orders.

With more pairs, all orders are reassigned only every ``LARGE_EVERY`` steps. In the other steps,
only robots without an order get one.
"""


class RobotStates(NamedTuple):
    """The robots before a step; all arrays are ``[R]``, and cells are numbers.

    For robots that drive through, ``cells`` are the ends of their ``Routes``. The ``goals`` are the
    cells where robots have to pick or drop, or ``NONE``.
    """

    cells: Integers
    goals: Integers
    loaded: Flags
    ended: Flags
    battery: NDArray[np.float64]


class Scheduler:
    """Scheduler that gives the robots of a fleet orders, turns at chargers, and goals.

    Args:
        env: fleet, after its reset.
        assignment: a name of ``ASSIGNMENTS``.
        known: graph of the planner, with the costs of moves and turns; ``None`` is without costs.
    """

    def __init__(self, env: FleetEnv, assignment: str, known: Graph | None = None) -> None:
        self.graph = Graph(env.layout)
        self._fields = Fields(self.graph)
        turn = known.turn_cost if known else 0.0
        self._times = TravelTimes(env.layout, 1.0 if env.settings.has_headings else turn)
        self._cell_steps: float = with_defaults(env.motion).cell_steps
        self.chargers = Chargers(env, self._times)
        self._assign, self._reassigns = ASSIGNMENTS[assignment], assignment in REASSIGNING
        self._capacity = env.settings.battery.capacity
        self._parking = parking_of(env.layout)
        self._assigned = (b"", b"")
        self._is_idle = np.zeros(env.settings.robots, np.bool_)
        self._detours = Detours(known or self.graph, env.settings.robots, self._cell_steps)
        self._escapes = Escapes(self._fields, env.settings.robots, self._cell_steps)
        self._was_charging = self._is_idle

    def situation(self, env: FleetEnv) -> tuple[Situation, NDArray[np.intp]]:
        """Assign orders; return the situation before the next step and the robots' actions.

        The action of a robot is ``PICK`` or ``DROP``, or ``WAIT`` if it moves or waits.
        """
        routes, count = env.routes, env.settings.robots
        dead = [cell for cell, units in zip(env.cells, env.battery, strict=True) if units <= 0]
        self._close(frozenset(map(env.layout.number, [*routes.closed, *dead])))
        robots = self._look(env, routes.ends[:count])
        self._send_to_chargers(robots)
        if env.settings.orders is not None:
            robots = self._give_orders(env, robots)
        self._is_idle = robots.goals == NONE
        goals, has_turn = self._goals(robots), self.chargers.turn != NONE
        at_work = (robots.cells == robots.goals) & ~robots.ended & ~has_turn
        shares = shares_cell(robots.cells)
        stay_long = robots.ended | self.chargers.charging(robots.cells)
        closed = dict.fromkeys([*env.people, *routes.ends[count:], *routes.closed])
        cells = env.layout.numbers(list(closed))
        hurries = has_turn.copy()
        aims = self._detours.goals(robots.cells, goals, stay_long, cells)
        people = env.layout.numbers(env.people)
        walls = {*robots.cells[stay_long | shares].tolist(), *cells.tolist()} - {*people.tolist()}
        aims |= self._escape(robots, goals, bool(at_work.any()), walls, people)
        for robot, aim in aims.items():
            goals[robot], hurries[robot] = aim, True
        stays = stay_long | at_work | shares | ~np.array(routes.has_room[:count])
        stays[self._escapes.held] |= goals[self._escapes.held] == robots.cells[self._escapes.held]
        is_away = goals != robots.cells
        urgent, undelayed = (np.flatnonzero(each & is_away) for each in (hurries, has_turn))
        at_rest = at_work & np.array(routes.at_rest[:count])
        actions = np.where(at_rest, np.where(robots.loaded, DROP, PICK), WAIT)
        return Situation(robots.cells, goals, stays, cells, urgent, undelayed), actions

    def _escape(
        self, robots: RobotStates, goals: Integers, is_done: bool, walls: set[int], people: Integers
    ) -> dict[int, int]:
        """Return the cells that robots must have after this step, by robot, if they are stuck."""
        is_charging = self.chargers.charging(robots.cells)
        is_away = ((robots.goals != NONE) | (self.chargers.turn != NONE)) & ~robots.ended
        away = np.flatnonzero(is_away & (goals != robots.cells) & ~is_charging)
        distances = np.full(len(goals), FAR)
        distances[away] = self._fields.distances(goals[away], robots.cells[away])
        is_done |= bool((is_charging != self._was_charging).any())
        self._was_charging = is_charging
        return self._escapes.aims(robots.cells, goals, distances, walls, people, is_done)

    def _close(self, cells: frozenset[int]) -> None:
        """Close the cells of failed robots, so that no path uses them."""
        if cells != self.graph.closed:
            self.graph.close(cells)
            self._times.close(cells)
            self.chargers.measure()
            self._assigned = (b"", b"")

    def _look(self, env: FleetEnv, cells: Sequence[Cell]) -> RobotStates:
        arrays, width = env.arrays(), np.array([env.layout.width, 1])
        loaded = np.asarray(arrays["has_item"]) != 0
        places = np.where(loaded[:, None], arrays["dropoff_pos"], arrays["pickup_pos"])
        goals = np.where(places[:, 0] < 0, NONE, places @ width)
        battery = arrays["battery"][:, 0].astype(np.float64)
        return RobotStates(np.array(cells) @ width, goals, loaded, np.array(env.ended), battery)

    def _send_to_chargers(self, robots: RobotStates) -> None:
        """Update the turns at chargers; a robot that can still deliver its item does so first."""
        may_go = ~robots.ended
        carrying = np.flatnonzero(robots.loaded & may_go & (robots.goals != NONE))
        goals = robots.goals[carrying]
        times = self._times.between(robots.cells[carrying], goals) + self.chargers.home[goals]
        may_go[carrying] = ~self.chargers.lasts(robots.battery[carrying], times)
        shares = np.where(robots.goals == NONE, np.where(self._is_idle, IDLE, BETWEEN), 0.0)
        is_near = self.chargers.home[robots.cells] <= QUEUE_DISTANCE
        shares = np.where(is_near, np.maximum(shares, NEAR), shares)
        battery = np.where(robots.ended, 0.0, robots.battery)
        self.chargers.update(Needs(robots.cells, battery, may_go, shares * self._capacity))

    def _give_orders(self, env: FleetEnv, robots: RobotStates) -> RobotStates:
        """Assign open orders, and return the robots with the goals of their orders."""
        known = env.order_arrays
        if not len(known.due):
            return robots
        order = np.array([NONE if each is None else each for each in env.order_of])
        is_charging, is_theirs = self.chargers.turn != NONE, known.robot[order] != NONE
        able = ~(robots.loaded | robots.ended) & ((order == NONE) | ~is_theirs)
        for robot in np.flatnonzero(able & is_charging & (order != NONE)).tolist():
            env.assign(robot, None)
            order[robot] = NONE
        able &= ~is_charging
        open_orders = np.array(env.open_orders, np.intp)
        is_large = np.count_nonzero(able) * len(open_orders) > MAX_PAIRS
        if not self._reassigns or (is_large and env.steps % LARGE_EVERY):
            able &= order == NONE
        free = np.flatnonzero(able)
        columns = np.union1d(open_orders, order[free[order[free] != NONE]])
        state = free.tobytes(), columns.tobytes()
        is_new, self._assigned = state != self._assigned, state
        if len(open_orders) and len(free) and is_new:
            self._change_orders(env, robots, free, columns, order)
        goals = np.where(order == NONE, NONE, known.pickup[order])
        return robots._replace(goals=np.where(robots.loaded, robots.goals, goals))

    def _change_orders(
        self, env: FleetEnv, robots: RobotStates, free: Integers, columns: Integers, order: Integers
    ) -> None:
        """Assign these orders to these robots, and update ``order``."""
        known, cells = env.order_arrays, robots.cells[free]
        pickups, dropoffs = known.pickup[columns], known.dropoff[columns]
        times = self._times.between(cells[:, None], pickups)
        trips = self._times.between(pickups, dropoffs)
        if len(self.chargers.cells):
            whole = times + trips + self.chargers.home[dropoffs]
            times[~self.chargers.lasts(robots.battery[free, None], whole)] = np.inf
        times[:, ~np.isfinite(trips)] = np.inf
        held = np.where(order[free] == NONE, NONE, np.searchsorted(columns, order[free]))
        due, now = known.due[columns] / self._cell_steps, env.steps / self._cell_steps
        given = self._assign(Tasks(times, trips, due, now, held))
        new = np.where(given == NONE, NONE, columns[given])
        changed = np.flatnonzero(new != order[free])
        for robot in free[changed[order[free[changed]] != NONE]].tolist():
            env.assign(robot, None)
        for place in changed[new[changed] != NONE].tolist():
            env.assign(int(free[place]), int(new[place]))
        order[free] = new

    def _goals(self, robots: RobotStates) -> Integers:
        """Return the goal of each robot; robots without a task park out of the way."""
        parking = self._parking[robots.cells]
        goals = np.where(robots.goals == NONE, parking, robots.goals)
        charging = self.chargers.goals(robots.cells)
        return np.where(self.chargers.turn == NONE, goals, charging)


def parking_of(layout: Layout) -> NDArray[np.intp]:
    """Return for each cell where a robot in it should park, ``[H * W]``.

    This is the nearest cell that is neither a station or charger nor next to one. If all cells are
    next to stations, it is the nearest cell that is not one.
    """
    busy = {*layout.pickups, *layout.dropoffs, *layout.chargers}
    adjacent = {(row + down, col + right) for row, col in busy for down, right in DISPLACEMENTS}
    free = [cell for cell in layout.cells(layout.open_cells) if cell not in busy]
    to = nearest(layout, [cell for cell in free if cell not in adjacent] or free).ravel()
    return np.where(to < 0, np.arange(len(to)), to)


def shares_cell(cells: Integers) -> Flags:
    """Return whether each robot shares its cell with another, as bodies may after a disturbance."""
    return np.bincount(cells)[cells] > 1
