"""Charging schedule: which robot charges at which charger, and when.

At each charger, one robot has a turn: it charges there or drives there. At most one more robot is
next, and waits some cells away so that it does not block the robot that leaves. The turns of robots
that are still far from their chargers are given anew in each step, so that a charger does not wait
for a blocked robot. Robots without a turn that are pushed across a charger do not charge there, and
no robot waits for them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.fleet.travel import TravelTimes
from agents.mapf.assignment import OUT_OF_REACH, cheapest_matching
from agents.mapf.graph import Costs, Graph
from agents.mapf.kernels.places import NONE
from warehouse_core import FleetEnv, Layout
from warehouse_core.batch.fleet_settings import STEPS
from warehouse_core.motion.base import BaseMotion, with_defaults
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

DETOUR = 2.0
"""Ratio of the longest expected path to the shortest path."""

SPARE_STEPS, SPARE_SHARE = 60.0, 0.4
"""Reserve in steps that a robot keeps for the drive to a charger, and its limit as a share of a
full battery.

The reserve comes on top of ``DETOUR`` times the distance to the charger. Robots that give way to
each other in a narrow aisle need it, and people block robots for even longer. With a limit of 0.25,
171 and not 112 of 2,819 robots ran out of battery on 218 random floors without people, and 87 and
not 68 of 236 on 19 floors with people, but 2.5% more orders were delivered.
"""

MARGIN = 1.2
"""Safety factor on the expected time until a robot's turn."""

GAP = 5.0
"""Steps from the end of a turn at a charger until the next robot charges there."""

ENOUGH = 0.7
"""Share of a full battery above which a robot may take any order and does not have to charge."""

NEARBY, PATIENCE = 10.0, 5.0
"""Limits on the extra distance, compared with the nearest charger, and on waiting, in steps.

They do not apply to a robot that would otherwise run out of battery. It goes to any charger that it
can reach, and waits there.
"""

HASTE = 0.25
"""Weight of the remaining battery life against the distance to a charger, both in steps."""

HALF = 0.5
"""Share of a full battery above which a robot leaves its charger to a robot in need."""

QUEUE_DISTANCE = 3
"""Distance from its charger, in cells, at which the next robot waits.

Only robots within this distance keep their turns. With permanent turns, chargers stood unused in
congested aisles: 175 and not 81 robots ran out of battery on 29 random floors with people, and 17%
fewer orders were delivered.
"""

INTO_CHARGER = 25.0
"""Extra cost of a move into a charger, where a robot may charge for a long time.

Results are the same with 5 and with 20. Without this cost, paths would lead through occupied
chargers.
"""


def costs_around_chargers(layout: Layout, costs: Costs | None = None) -> Costs | None:
    """Return costs of moves ``[H * W, 4]``, see ``Graph``, with which paths avoid chargers.

    Planners do not plan around robots that stay. ``None`` as an argument stands for costs of 1. The
    costs are returned unchanged if the layout has no chargers.
    """
    if not layout.chargers:
        return costs
    reached = Graph(layout).neighbours[:, :WAIT]
    into = np.where(np.isin(reached, layout.numbers(layout.chargers)), INTO_CHARGER, 0.0)
    return (into + (1.0 if costs is None else costs)).astype(np.float32)


def use_and_charge(env: FleetEnv) -> tuple[float, float]:
    """Return the battery units to cross a cell, and the units that could be charged meanwhile.

    If the unit is joules, the motion gives the energy of the robot's body, or else its nominal
    value is used.
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
    """The needs of ``R`` robots; all arrays are ``[R]``.

    Attributes:
        cells: cells of the robots.
        battery: units left. Robots with a flat battery get no turn.
        may_go: true for robots that may go to charge now.
        limits: units below which a robot goes to an unused charger. The limits apply to chargers
            that charge to a full battery at constant current, and are lower for others.
    """

    cells: Integers
    battery: NDArray[np.float64]
    may_go: NDArray[np.bool_]
    limits: NDArray[np.float64]


class Chargers:
    """The chargers of a floor, and the robots that have turns at them.

    Charging is scheduled by earliest deadline first. The deadline of a robot is the step in which
    its battery will be flat. The robots take turns in the order of their deadlines, each when the
    chargers have finished with the robots before it. If a robot would miss its deadline, it and all
    robots before it have to charge now. If this estimate turns out to be wrong, turns end early in
    favour of robots that would run out of battery.

    Attributes:
        cells: ``[C]``, cells of the chargers.
        home: ``[H * W]``, time from each cell to the nearest charger, see ``TravelTimes``.
        turn: ``[R]``, charger where each robot charges or will charge, or ``NONE``.

    Source: Liu and Layland (1973), Scheduling algorithms for multiprogramming in a hard-real-time
    environment, for the order of the deadlines.
    """

    def __init__(self, env: FleetEnv, times: TravelTimes) -> None:
        battery, layout = env.settings.battery, env.layout
        self.cells = layout.numbers(layout.chargers)
        self._times, self._all = times, np.arange(layout.height * layout.width)
        self.measure()
        self._capacity, (self._cost, charge) = battery.capacity, use_and_charge(env)
        self._reserve = min(SPARE_STEPS, SPARE_SHARE * battery.capacity / self._cost)
        self._gain = max(charge - self._cost, 0.0) or self._cost
        # Beyond the knee charging is slow, and the next robot gains more.
        knee = battery.capacity - battery.tail
        self._full = max(min(battery.capacity - charge, knee), ENOUGH * battery.capacity)
        # A robot whose turn would end at once does not go to a charger.
        self._scale = max(knee / battery.capacity, ENOUGH)
        # The charge that is missing at the end of a turn, and the part of it at constant voltage,
        # in which the missing charge falls exponentially to the cost of a step.
        self._slow, self._fall = max(self._full - knee, 0.0), battery.tail / charge
        self._left = max(battery.capacity - self._full - self._fall * self._cost, self._cost)
        self.turn = np.full(env.settings.robots, NONE)
        self._first = np.full(len(self.cells), NONE)
        self._leaves = np.full(len(self.cells), NONE)

    def measure(self) -> None:
        """Measure the times to the chargers again, because other cells are closed now."""
        self._distances = self._times.between(self._all, self.cells[:, None])
        self.home = self._distances.min(axis=0, initial=np.inf)

    def lasts(
        self, battery: NDArray[np.float64], distances: NDArray[np.floating]
    ) -> NDArray[np.bool_]:
        """Return whether batteries last for paths of this many steps that end at a charger.

        A battery above ``ENOUGH`` counts as sufficient for every path, because the robot can charge
        on the way.
        """
        needed = self._cost * (DETOUR * distances + self._reserve)
        result: NDArray[np.bool_] = battery >= np.minimum(needed, ENOUGH * self._capacity)
        return result

    def update(self, needs: Needs) -> None:
        """End the turns of robots that have charged or are far away, and give turns."""
        if not len(self.cells):
            return
        empty = needs.battery <= 0
        is_blocked = np.isin(self.cells, needs.cells[empty])
        distances = self._distances[self.turn, needs.cells]
        # A robot that arrives with a flat battery would block the charger for good.
        is_late = (needs.battery <= self._cost * distances) & (distances > 0)
        over = (needs.battery >= self._full) | empty | is_blocked[self.turn] | is_late
        over |= distances > QUEUE_DISTANCE
        self.turn[over] = NONE
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
        """Return the cell to which each robot with a turn has to go, ``[R]``, or ``NONE``."""
        goals = np.full(len(cells), NONE)
        robots = np.flatnonzero(self.turn != NONE)
        chargers, here = self.turn[robots], cells[robots]
        is_used = self._leaving(cells)[chargers] != NONE
        is_used |= self._first[chargers] != robots
        waits = is_used & (self._distances[chargers, here] <= QUEUE_DISTANCE)
        waits &= here != self.cells[chargers]
        goals[robots] = np.where(waits, here, self.cells[chargers])
        return goals

    def charging(self, cells: Integers) -> NDArray[np.bool_]:
        """Return whether each robot is at the charger where it has a turn, ``[R]``."""
        result = np.zeros(len(cells), np.bool_)
        used = np.flatnonzero(self._first != NONE)
        first = self._first[used]
        result[first] = (cells[first] == self.cells[used]) & (self.turn[first] == used)
        return result

    def _leaving(self, cells: Integers) -> NDArray[np.intp]:
        """Return the robot that has charged at each charger and is still there, or ``NONE``."""
        stays_on = self.turn[self._leaves] == np.arange(len(self._leaves))
        self._leaves[stays_on | (cells[self._leaves] != self.cells)] = NONE
        return self._leaves

    def _give_way(self, needs: Needs) -> None:
        """End turns early in favour of robots that would run out of battery.

        A charging robot gives way to the next robot at its charger. If robots in need have no turn,
        next robots that are not in need give theirs back.
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

        This is the robot that charges there, or else the nearest robot with a turn.
        """
        robots = np.flatnonzero(self.turn != NONE)
        chargers, first = self.turn[robots], self._first
        has_ended = (first != NONE) & (self.turn[first] != np.arange(len(first)))
        is_there = cells[first] == self.cells
        leaves = has_ended & is_there
        self._leaves[leaves] = first[leaves]
        first[has_ended | ~is_there] = NONE
        by_distance = np.argsort(-self._distances[chargers, cells[robots]], kind="stable")
        by_distance = by_distance[first[chargers[by_distance]] == NONE]
        first[chargers[by_distance]] = robots[by_distance]
        return first

    def _until(self, holder: Integers, needs: Needs) -> NDArray[np.float64]:
        """Return the steps until each charger is free, ``[C]``."""
        until, used = np.zeros(len(holder)), np.flatnonzero(holder != NONE)
        robots = holder[used]
        distances = self._distances[used, needs.cells[robots]]
        until[used] = distances + self._charging_steps(needs.battery[robots], distances)
        return until

    def _low(self, holder: Integers, until: NDArray[np.float64], needs: Needs) -> NDArray[np.bool_]:
        """Return whether each robot has to charge now, ``[R]``; see the class."""
        home = DETOUR * self.home[needs.cells]
        turns, spare = GAP + self._charging_steps(needs.battery, home), self._spare(needs)
        coming = self.turn != NONE
        coming[holder[holder != NONE]] = False
        robots = np.flatnonzero((self.turn == NONE) & (needs.battery > 0) & np.isfinite(home))
        robots = robots[np.argsort(spare[robots], kind="stable")]
        # Each step of waiting makes a robot's turn longer, which adds up like compound interest.
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
        """Assign robots to chargers so that they begin to charge as early as possible."""
        distances = self._distances[chargers][:, needs.cells[robots]].T
        spare = self._spare(needs)[robots, None]
        waits = np.maximum(until - DETOUR * np.minimum(distances, OUT_OF_REACH), 0)
        near = distances <= self.home[needs.cells[robots], None] + NEARBY
        reached = self._cost * distances < needs.battery[robots, None]
        allowed = reached & ((spare < self._reserve) | near & (waits <= PATIENCE))
        costs = np.where(allowed, distances + waits + HASTE * spare, OUT_OF_REACH)
        rows, columns = cheapest_matching(costs)
        given = allowed[rows, columns]
        self.turn[robots[rows[given]]] = chargers[columns[given]]

    def _spare(self, needs: Needs) -> NDArray[np.float64]:
        """Return the number of steps for which each battery lasts beyond the path to a charger."""
        result: NDArray[np.float64] = needs.battery / self._cost - DETOUR * self.home[needs.cells]
        return result

    def _charging_steps(
        self, battery: NDArray[np.float64], distances: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the charging time in steps after paths of this many steps."""
        missing = np.maximum(self._full - battery + self._cost * distances, 0)
        slow = np.minimum(missing, self._slow)
        steps: NDArray[np.float64] = (missing - slow) / self._gain
        return steps + self._fall * np.log1p(slow / self._left)
