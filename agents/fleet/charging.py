"""Charging as a task: which robot goes to which charger, and when.

Each charger has one robot that charges there or goes there, until its turn has ended, and at most
one more that comes next and waits some cells away, so that nobody is in the way of the one that
leaves. Others who are pushed across the charger do not charge there, and nobody waits for them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.mapf.assignment import NONE, OUT_OF_REACH, cheapest_matching
from agents.mapf.graph import CLOSED, MOVES, Costs, Graph
from warehouse_core import FleetEnv, Layout
from warehouse_core.batch.fleet_settings import STEPS
from warehouse_core.motion.base import BaseMotion, with_defaults
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.tables import Integers

DETOUR = 2.0
"""Factor by which a way may be longer than the shortest."""

SPARE_STEPS, SPARE_SHARE = 60.0, 0.25
"""Steps for which the battery of a robot lasts beyond ``DETOUR`` times its way to a charger when it
goes there, unless they take more than this share of a full battery.

With 20 steps two robots in a narrow aisle that give way to each other may run empty.
"""

MARGIN = 1.2
"""Factor by which the time until its turn may be longer than a robot counts on."""

GAP = 5.0
"""Steps from the end of a turn at a charger until the next robot charges there."""

ENOUGH = 0.7
"""Share of a full battery with which every robot may take every order, and none has to charge."""

NEARBY, PATIENCE = 10.0, 5.0
"""Steps more than to the nearest charger that a robot goes, and that it waits there; one that would
run empty goes to any that it reaches and waits."""

HASTE = 0.25
"""Weight of remaining battery life against the distance to a charger, both in steps."""

HALF = 0.5
"""Share of a full battery with which a robot leaves its charger to one that would run empty."""

QUEUE_DISTANCE = 3
"""Cells from its charger at which the robot that comes next waits."""

INTO_CHARGER = 25.0
"""Additional cost of a move into a charger, where somebody may charge for long.

Fleets do the same with 5 and with 20; without it, ways lead through chargers that are in use.
"""


def costs_around_chargers(layout: Layout, costs: Costs | None = None) -> Costs | None:
    """Return costs of moves ``[H * W, 4]``, see ``Graph``, so that ways lead around chargers.

    Planners do not look for a way around robots that stay. ``None`` stands for costs of 1 each, and
    is returned if there are no chargers.
    """
    if not layout.chargers:
        return costs
    size = layout.height * layout.width
    around = np.ones((size, len(MOVES)), np.float32) if costs is None else costs.copy()
    chargers = layout.numbers(layout.chargers)
    for move in MOVES:
        down, right = DISPLACEMENTS[move]
        around[(chargers - down * layout.width - right) % size, move] += INTO_CHARGER
    return around


def use_and_charge(env: FleetEnv) -> tuple[float, float]:
    """Return the units that a robot uses for a cell, and those that a charger adds meanwhile.

    In joules a robot uses what the motion says of its body, or what is nominal.
    """
    motion: BaseMotion = with_defaults(env.motion)
    battery, cell_steps = env.settings.battery, motion.cell_steps
    use = battery.step_cost(env.cell_size)
    if battery.unit == STEPS:
        use *= cell_steps
    elif motion.cell_joules is not None:
        use = motion.cell_joules
    return use, battery.step_charge(env.cell_size) * cell_steps


class Needs(NamedTuple):
    """What ``R`` robots need; all arrays are ``[R]``.

    Attributes:
        cells: cells of the robots.
        battery: units left; robots without any have no turn.
        may_go: true for robots that may go to charge now.
        limits: units below which a robot goes to a charger that nobody uses, where chargers charge
            up to a full battery at a constant current.
    """

    cells: Integers
    battery: NDArray[np.float64]
    may_go: NDArray[np.bool_]
    limits: NDArray[np.float64]


class Chargers:
    """The chargers of a floor, and the robots that have turns at them.

    When it is time to charge follows from a schedule by earliest deadline: the robots take turns
    in the order of the steps that their batteries last, each when the chargers are done with those
    before it. If one of them would run empty until then, it and all before it are to charge now.
    If it was wrong, turns end early for those that would run empty.

    Attributes:
        cells: ``[C]``, cells of the chargers.
        home: ``[H * W]``, cost of the way from each cell to the nearest charger, in steps.
        turn: ``[R]``, charger where each robot charges or is to charge, or ``NONE``.

    Source: Liu and Layland (1973), Scheduling algorithms for multiprogramming in a hard-real-time
    environment, for the order of the deadlines.
    """

    def __init__(self, env: FleetEnv, graph: Graph) -> None:
        battery, layout = env.settings.battery, env.layout
        self.cells = layout.numbers(layout.chargers)
        ways = [_ways_into(graph, cell) for cell in self.cells.tolist()]
        self._ways = np.array(ways, np.float64).reshape(-1, graph.size)
        self.home = self._ways.min(axis=0, initial=np.inf)
        self._capacity, (self._cost, charge) = battery.capacity, use_and_charge(env)
        self._reserve = min(SPARE_STEPS, SPARE_SHARE * battery.capacity / self._cost)
        self._gain = max(charge - self._cost, 0.0) or self._cost
        # Beyond the knee a charger is slow, and does more for the next robot.
        knee = battery.capacity - battery.tail
        self._full = max(min(battery.capacity - charge, knee), ENOUGH * battery.capacity)
        # A robot that its charger would send away at once does not go there.
        self._scale = max(knee / battery.capacity, ENOUGH)
        # What is missing at the end of a turn, and what of the turn is at a constant voltage, where
        # what is missing falls exponentially to what a step costs.
        self._slow, self._fall = max(self._full - knee, 0.0), battery.tail / charge
        self._left = max(battery.capacity - self._full - self._fall * self._cost, self._cost)
        self.turn = np.full(env.settings.robots, NONE)
        self._first = np.full(len(self.cells), NONE)
        self._leaves = np.full(len(self.cells), NONE)

    def lasts(self, battery: NDArray[np.float64], ways: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Return whether batteries last for ways of so many steps that end at a charger.

        One with ``ENOUGH`` is said to last for all: it can be charged on the way.
        """
        needed = self._cost * (DETOUR * ways + self._reserve)
        found: NDArray[np.bool_] = battery >= np.minimum(needed, ENOUGH * self._capacity)
        return found

    def update(self, needs: Needs) -> None:
        """End the turns of robots that have charged, and give turns to others."""
        if not len(self.cells):
            return
        empty = needs.battery <= 0
        is_blocked = self._are_there(needs.cells[empty])
        self.turn[(needs.battery >= self._full) | empty | is_blocked[self.turn]] = NONE
        self._give_way(needs)
        holder = self._choose_first(needs.cells)
        until = self._until(holder, needs)
        may_go = needs.may_go & np.isfinite(self.home[needs.cells])
        is_below = needs.battery < self._scale * needs.limits
        for low, most in (self._low(holder, until, needs), 1), (is_below, 0):
            robots = np.flatnonzero(low & may_go & (self.turn == NONE))
            counts = np.bincount(self.turn + 1, minlength=len(holder) + 1)[1:]
            chargers = np.flatnonzero((counts <= most) & ~is_blocked)
            if len(robots) and len(chargers):
                self._give_turns(robots, chargers, until[chargers], needs)
        self._choose_first(needs.cells)

    def goals(self, cells: Integers) -> NDArray[np.intp]:
        """Return the cell that each robot with a turn is to go to, ``[R]``, or ``NONE``."""
        goals = np.full(len(cells), NONE)
        robots = np.flatnonzero(self.turn != NONE)
        chargers, here = self.turn[robots], cells[robots]
        is_used = self._leaving(cells)[chargers] != NONE
        is_used |= self._first[chargers] != robots
        waits = is_used & (self._ways[chargers, here] <= QUEUE_DISTANCE)
        waits &= here != self.cells[chargers]
        goals[robots] = np.where(waits, here, self.cells[chargers])
        return goals

    def charging(self, cells: Integers) -> NDArray[np.bool_]:
        """Return whether each robot is at the charger where it has a turn, ``[R]``."""
        found = np.zeros(len(cells), np.bool_)
        used = np.flatnonzero(self._first != NONE)
        first = self._first[used]
        found[first] = (cells[first] == self.cells[used]) & (self.turn[first] == used)
        return found

    def _leaving(self, cells: Integers) -> NDArray[np.intp]:
        """Return the robot that has charged at each charger and is still there, or ``NONE``."""
        stays_on = self.turn[self._leaves] == np.arange(len(self._leaves))
        self._leaves[stays_on | (cells[self._leaves] != self.cells)] = NONE
        return self._leaves

    def _are_there(self, cells: Integers) -> NDArray[np.bool_]:
        """Return whether each charger is one of some cells, ``[C]``; faster than ``isin``."""
        is_there = np.zeros(len(self.home), np.bool_)
        is_there[cells] = True
        return is_there[self.cells]

    def _give_way(self, needs: Needs) -> None:
        """End turns early for robots that would run empty.

        Who charges gives way to the one that comes next. If robots have no turn, those that come
        next but would not run empty give theirs back.
        """
        spare, has_turn = self._spare(needs), self.turn != NONE
        is_first = self._choose_first(needs.cells)[self.turn] == np.arange(len(spare))
        is_next = has_turn & ~is_first
        hurries = np.bincount(self.turn[is_next & (spare < GAP)], minlength=len(self.cells)) > 0
        charged = has_turn & is_first & (needs.battery >= HALF * self._capacity)
        self.turn[charged & hurries[self.turn]] = NONE
        in_need = needs.may_go & (needs.battery > 0) & (spare < self._reserve)
        if (in_need & ~has_turn).any():
            self.turn[is_next & ~in_need] = NONE

    def _choose_first(self, cells: Integers) -> NDArray[np.intp]:
        """Return the robot whose turn it is at each charger, ``[C]``, or ``NONE``.

        It stays the same until its turn has ended; then it is the nearest of the others.
        """
        robots = np.flatnonzero(self.turn != NONE)
        chargers, first = self.turn[robots], self._first
        has_ended = (first != NONE) & (self.turn[first] != np.arange(len(first)))
        there = has_ended & (cells[first] == self.cells)
        self._leaves[there] = first[there]
        first[has_ended] = NONE
        by_way = np.argsort(-self._ways[chargers, cells[robots]], kind="stable")
        by_way = by_way[first[chargers[by_way]] == NONE]
        first[chargers[by_way]] = robots[by_way]
        return first

    def _until(self, holder: Integers, needs: Needs) -> NDArray[np.float64]:
        """Return the steps until each charger is free, ``[C]``."""
        until, used = np.zeros(len(holder)), np.flatnonzero(holder != NONE)
        robots = holder[used]
        ways = self._ways[used, needs.cells[robots]]
        until[used] = ways + self._charging_steps(needs.battery[robots], ways)
        return until

    def _low(self, holder: Integers, until: NDArray[np.float64], needs: Needs) -> NDArray[np.bool_]:
        """Return whether each robot is to charge now, ``[R]``; see the class."""
        home = DETOUR * self.home[needs.cells]
        turns, spare = GAP + self._charging_steps(needs.battery, home), self._spare(needs)
        coming = self.turn != NONE
        coming[holder[holder != NONE]] = False
        robots = np.flatnonzero((self.turn == NONE) & (needs.battery > 0) & np.isfinite(home))
        robots = robots[np.argsort(spare[robots], kind="stable")]
        # Each step until its turn makes the turn of a robot longer, which grows like interest.
        growth = (1 + self._cost / self._gain / len(self.cells)) ** np.arange(len(robots))
        before = np.cumsum(np.append(0.0, (turns[robots] / growth)[:-1]))
        waiting = growth * (until.sum() + turns[coming].sum() + before) / len(self.cells)
        late = np.flatnonzero(spare[robots] < MARGIN * waiting + self._reserve)
        low = np.zeros(len(spare), np.bool_)
        low[robots[: late[-1] + 1 if len(late) else 0]] = True
        return low

    def _give_turns(
        self, robots: Integers, chargers: Integers, until: NDArray[np.float64], needs: Needs
    ) -> None:
        """Give robots turns at chargers, so that they begin as soon as can be."""
        ways = self._ways[chargers][:, needs.cells[robots]].T
        waits, spare = np.maximum(until - DETOUR * ways, 0), self._spare(needs)[robots, None]
        near = ways <= self.home[needs.cells[robots], None] + NEARBY
        reached = self._cost * ways <= needs.battery[robots, None]
        allowed = reached & ((spare < self._reserve) | near & (waits <= PATIENCE))
        costs = np.where(allowed, ways + waits + HASTE * spare, OUT_OF_REACH)
        rows, columns = cheapest_matching(costs)
        given = allowed[rows, columns]
        self.turn[robots[rows[given]]] = chargers[columns[given]]

    def _spare(self, needs: Needs) -> NDArray[np.float64]:
        """Return for how many steps each battery lasts beyond the way to a charger."""
        found: NDArray[np.float64] = needs.battery / self._cost - DETOUR * self.home[needs.cells]
        return found

    def _charging_steps(
        self, battery: NDArray[np.float64], ways: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the steps of charging after ways of so many steps."""
        missing = np.maximum(self._full - battery + self._cost * ways, 0)
        slow = np.minimum(missing, self._slow)
        steps: NDArray[np.float64] = (missing - slow) / self._gain
        return steps + self._fall * np.log1p(slow / self._left)


def _ways_into(graph: Graph, charger: int) -> Costs:
    """Return the cost of the way from each cell to a charger, ``[H * W]``, the last move 1."""
    ways, sides = graph.distances(charger, keep=False), graph.neighbours[charger, :WAIT]
    last = ways[sides[sides != CLOSED]].min(initial=np.inf)
    return np.maximum(ways - (last - 1), 0) if np.isfinite(last) else ways
