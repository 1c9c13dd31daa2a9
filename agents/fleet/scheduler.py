"""What each robot of a fleet is to do: its order, its charger, or a place out of the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.fleet.charging import Chargers, Needs
from agents.fleet.detours import Detours
from agents.fleet.escapes import Escapes
from agents.mapf.assignment import ASSIGNMENTS, NONE, REASSIGNING, Tasks
from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import FAR
from agents.mapf.planner import Situation
from warehouse_core import Cell, FleetEnv
from warehouse_core.motion.base import with_defaults
from warehouse_core.world.actions import DISPLACEMENTS, DROP, PICK, WAIT
from warehouse_core.world.distances import nearest
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers

IDLE, BETWEEN = 0.9, 0.5
"""Shares of a full battery below which a robot that has no order, or has just delivered one, goes
to a charger that nobody uses."""

MAX_PAIRS, LARGE_EVERY = 40_000, 10
"""Pairs of a robot and an order up to which orders are assigned anew in each step. With more pairs
that happens every ``LARGE_EVERY`` steps, and in the others only robots without an order get one."""


class RobotStates(NamedTuple):
    """The robots before a step, ``[R]`` each; cells are numbers.

    The ``cells`` of robots that drive through are the ends of their ``Routes``. The ``goals`` are
    cells where robots are to pick or drop, or ``NONE``.
    """

    cells: Integers
    goals: Integers
    loaded: Flags
    ended: Flags
    battery: NDArray[np.float64]


class Duties(NamedTuple):
    """What each of ``R`` robots is to do next, ``[R]`` each but for the robots.

    Attributes:
        robots: robots with the goals that their orders give them.
        goals: cells to go to: to pick or drop, to charge, or to be out of the way.
        stays: true for robots that cannot move in the next step, whoever is beside them.
        actions: ``PICK`` or ``DROP``, or ``WAIT`` if a robot moves or waits.
    """

    robots: RobotStates
    goals: Integers
    stays: Flags
    actions: NDArray[np.intp]


class Scheduler:
    """Gives the robots of a fleet, after its reset, orders, turns at chargers, and goals.

    Args:
        env: fleet.
        assignment: a name of ``ASSIGNMENTS``.
        known: graph of the planner, with the costs of moves by which robots find their ways, and
            the time that they take to turn; ``None`` is without both.
    """

    def __init__(self, env: FleetEnv, assignment: str, known: Graph | None = None) -> None:
        self.graph = Graph(env.layout)
        roads = Graph(env.layout, known.costs) if known else self.graph
        self._fields = Fields(self.graph)
        # Who is near is a matter of time: of cells at top speed, and of turns.
        turns = known.turn_cost if known else 0.0
        self._times = Fields(self.graph.with_turns(turns)) if turns else self._fields
        self._cell_steps: float = with_defaults(env.motion).cell_steps
        self.chargers = Chargers(env, roads)
        self._assign, self._reassigns = ASSIGNMENTS[assignment], assignment in REASSIGNING
        self._capacity = env.settings.battery.capacity
        self._parking = parking_of(env.layout)
        self._trips = self._homes = np.empty(0)
        self._assigned = (b"", b"")
        self._is_idle = np.zeros(env.settings.robots, np.bool_)
        self._detours = Detours(roads, env.settings.robots, self._cell_steps)
        self._escapes = Escapes(self._fields, env.settings.robots, self._cell_steps)
        self._was_charging = self._is_idle

    def situation(self, env: FleetEnv) -> tuple[Situation, NDArray[np.intp]]:
        """Return the situation before the next step, and the actions of robots that stay.

        Orders are assigned. A robot does ``PICK`` or ``DROP``, or ``WAIT`` if it moves or waits.
        """
        routes, count = env.routes, env.settings.robots
        robots, goals, stays, actions = self.duties(env)
        shares = shares_cell(robots.cells)
        stay_long = robots.ended | self.chargers.charging(robots.cells)
        closed = dict.fromkeys([*env.people, *routes.ends[count:], *routes.closed])
        cells = env.layout.numbers(list(closed))
        hurries = self.chargers.turn != NONE
        aims = self._detours.goals(robots.cells, goals, stay_long, cells)
        people = env.layout.numbers(env.people)
        walls = {*robots.cells[stay_long | shares].tolist(), *cells.tolist()} - {*people.tolist()}
        is_done = bool(self._are_at_work(robots).any())
        aims |= self._escape(robots, goals, is_done, walls, people)
        for robot, aim in aims.items():
            goals[robot], hurries[robot] = aim, True
        stays |= shares
        stays[self._escapes.held] |= goals[self._escapes.held] == robots.cells[self._escapes.held]
        urgent = np.flatnonzero(hurries & (goals != robots.cells))
        return Situation(robots.cells, goals, stays, cells, urgent), actions

    def duties(self, env: FleetEnv) -> Duties:
        """Return what each robot is to do, as if no other were in its way. Orders are assigned."""
        routes, count = env.routes, env.settings.robots
        dead = [cell for cell, units in zip(env.cells, env.battery, strict=True) if units <= 0]
        self._close(frozenset(map(env.layout.number, [*routes.closed, *dead])))
        robots = self._look(env, routes.ends[:count])
        self._send_to_chargers(robots)
        if env.settings.orders is not None:
            robots = self._give_orders(env, robots)
        self._is_idle = robots.goals == NONE
        at_work = self._are_at_work(robots)
        stays = robots.ended | self.chargers.charging(robots.cells) | at_work
        stays |= ~np.array(routes.has_room[:count])
        at_rest = at_work & np.array(routes.at_rest[:count])
        actions = np.where(at_rest, np.where(robots.loaded, DROP, PICK), WAIT)
        return Duties(robots, self._goals(robots), stays, actions)

    def _are_at_work(self, robots: RobotStates) -> Flags:
        """Return whether each robot is where it is to pick or drop, ``[R]``."""
        are_there: Flags = (robots.cells == robots.goals) & ~robots.ended
        are_there &= self.chargers.turn == NONE
        return are_there

    def _escape(
        self, robots: RobotStates, goals: Integers, is_done: bool, walls: set[int], people: Integers
    ) -> dict[int, int]:
        """Return where robots are to be after this step, by robot, if the fleet is stuck."""
        is_charging = self.chargers.charging(robots.cells)
        is_away = ((robots.goals != NONE) | (self.chargers.turn != NONE)) & ~robots.ended
        away = np.flatnonzero(is_away & (goals != robots.cells) & ~is_charging)
        ways = np.full(len(goals), FAR)
        ways[away] = self._fields.distances(goals[away], robots.cells[away])
        is_done |= bool((is_charging != self._was_charging).any())
        self._was_charging = is_charging
        return self._escapes.aims(robots.cells, goals, ways, walls, people, is_done)

    def _close(self, cells: frozenset[int]) -> None:
        """Let no way lead through the cells of robots that have failed."""
        if cells != self.graph.closed:
            self.graph.close(cells)
            self._times.graph.close(cells)
            self._trips = self._homes = np.empty(0)
            self._assigned = (b"", b"")

    def _look(self, env: FleetEnv, cells: Sequence[Cell]) -> RobotStates:
        found, width = env.arrays(), np.array([env.layout.width, 1])
        loaded = np.asarray(found["has_item"]) != 0
        places = np.where(loaded[:, None], found["dropoff_pos"], found["pickup_pos"])
        goals = np.where(places[:, 0] < 0, NONE, places @ width)
        battery = found["battery"][:, 0].astype(np.float64)
        return RobotStates(np.array(cells) @ width, goals, loaded, np.array(env.ended), battery)

    def _send_to_chargers(self, robots: RobotStates) -> None:
        """Give turns at chargers. A robot that can deliver its item before does it first."""
        may_go = ~robots.ended
        carrying = np.flatnonzero(robots.loaded & may_go & (robots.goals != NONE))
        goals = robots.goals[carrying]
        ways = self._ways(robots.cells[carrying], goals) + self.chargers.home[goals]
        may_go[carrying] = ~self.chargers.lasts(robots.battery[carrying], ways)
        shares = np.where(robots.goals == NONE, np.where(self._is_idle, IDLE, BETWEEN), 0.0)
        battery = np.where(robots.ended, 0.0, robots.battery)
        self.chargers.update(Needs(robots.cells, battery, may_go, shares * self._capacity))

    def _give_orders(self, env: FleetEnv, robots: RobotStates) -> RobotStates:
        """Assign open orders, and return the robots with the goals that this gives them."""
        known = env.order_arrays
        if not len(known.due):
            return robots
        self._measure(known.pickup, known.dropoff)
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
        if len(open_orders) and len(free) and state != self._assigned:
            self._change_orders(env, robots, free, columns, order)
            self._assigned = state
        goals = np.where(order == NONE, NONE, known.pickup[order])
        return robots._replace(goals=np.where(robots.loaded, robots.goals, goals))

    def _change_orders(
        self, env: FleetEnv, robots: RobotStates, free: Integers, columns: Integers, order: Integers
    ) -> None:
        """Assign these orders to these robots, and bring ``order`` up to date."""
        known, cells = env.order_arrays, robots.cells[free]
        ways = self._ways(cells[:, None], known.pickup[columns])
        if len(self.chargers.cells):
            whole = ways + self._trips[columns] + self._homes[columns]
            ways[~self.chargers.lasts(robots.battery[free, None], whole)] = np.inf
        ways[:, ~np.isfinite(self._trips[columns])] = np.inf
        held = np.where(order[free] == NONE, NONE, np.searchsorted(columns, order[free]))
        due, now = known.due[columns] / self._cell_steps, env.steps / self._cell_steps
        given = self._assign(Tasks(ways, self._trips[columns], due, now, held))
        new = np.where(given == NONE, NONE, columns[given])
        changed = np.flatnonzero(new != order[free])
        for robot in free[changed[order[free[changed]] != NONE]].tolist():
            env.assign(robot, None)
        for place in changed[new[changed] != NONE].tolist():
            env.assign(int(free[place]), int(new[place]))
        order[free] = new

    def _measure(self, pickups: Integers, dropoffs: Integers) -> None:
        """Measure the ways of orders that are new, from pickup to dropoff and to a charger."""
        first = len(self._trips)
        if first < len(pickups):
            trips = self._ways(pickups[first:], dropoffs[first:])
            self._trips = np.concatenate([self._trips, trips])
            self._homes = np.concatenate([self._homes, self.chargers.home[dropoffs[first:]]])

    def _ways(self, cells: Integers, goals: Integers) -> NDArray[np.float32]:
        """Return the times from cells to goals, arrays that are broadcast; a cell takes 1.

        Robots begin in the best direction.
        """
        times = self._times
        rows, headings = times.rows(goals), np.arange(0, times.graph.places, times.graph.size)
        ways = times.matrix[rows[..., None], cells[..., None] + headings].min(axis=-1)
        return np.where(ways == FAR, np.inf, ways / times.step).astype(np.float32)

    def _goals(self, robots: RobotStates) -> Integers:
        """Return where each robot is to go; those without anything to do out of the way."""
        parking = self._parking[robots.cells]
        goals = np.where(robots.goals == NONE, parking, robots.goals)
        charging = self.chargers.goals(robots.cells)
        return np.where(self.chargers.turn == NONE, goals, charging)


def parking_of(layout: Layout) -> NDArray[np.intp]:
    """Return the cell where a robot in each cell is out of the way, ``[H * W]``.

    It is the nearest that neither is a station or a charger nor beside one, if there is such a
    cell.
    """
    width = layout.width
    busy = {*layout.pickups, *layout.dropoffs, *layout.chargers}
    beside = {(row + down, col + right) for row, col in busy for down, right in DISPLACEMENTS}
    cells = layout.cells(layout.open_cells)
    found = np.arange(layout.height * width)
    for avoided in (busy | beside, busy):
        places = [cell for cell in cells if cell not in avoided]
        to = nearest(layout, places).ravel()
        if places:
            return np.where(to < 0, found, to)
    return found


def shares_cell(cells: Integers) -> Flags:
    """Return whether each robot shares its cell, as bodies may after a disturbance."""
    return np.bincount(cells)[cells] > 1
