"""Charging as a task: which robot goes to which charger, and when.

Each charger has one robot that charges there or goes there, and at most one more that comes next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from agents.mapf.graph import Graph, Integers
from warehouse_core import FleetEnv

NONE = -1
"""No charger, robot or cell."""

DETOUR, SPARE_STEPS = 2.0, 20.0
"""A robot counts on ``DETOUR`` times the shortest way, and keeps ``SPARE_STEPS`` more."""

QUEUE_DISTANCE = 3
"""Cells from a charger at which the robot that comes next waits."""

PATIENCE = 5.0
"""Steps that a robot may have to wait for its charger."""

MARGIN, WEIGHT = 1.2, 0.25
GAP = 5.0
NEARBY = 10.0
ENOUGH = 0.7
"""Share of a full battery below which a robot without an order goes to a free charger."""


class Chargers:
    """The chargers of a floor, and the robots that have a turn at them.

    When it is time to charge follows from a schedule by earliest deadline: robots take their turns
    in the order of the steps that their batteries last, and each has to wait until the chargers are
    done with those before it. If one of them would run empty, all before it are to charge now.

    Args:
        env: of the fleet.
        graph: of its floor.

    Attributes:
        home: ``[H * W]``, the steps from each cell to the nearest charger.
        turn: ``[R]``, the charger where each robot charges or is to charge, or ``NONE``.
    """

    def __init__(self, env: FleetEnv, graph: Graph) -> None:
        battery, layout = env.settings.battery, env.layout
        self.cells = np.array([row * layout.width + col for row, col in layout.chargers], np.intp)
        self._ways = np.array([graph.distances(cell) for cell in self.cells.tolist()], np.float32)
        self._ways = self._ways.reshape(-1, graph.size)
        self.home = self._ways.min(axis=0, initial=np.inf)
        self._cost = battery.step_cost(env.cell_size)
        charge = battery.step_charge(env.cell_size)
        self._gain = max(charge - self._cost, 0.0) or self._cost
        self._capacity = battery.capacity
        self._full = max(battery.capacity - charge, ENOUGH * battery.capacity)
        self.turn = np.full(env.settings.robots, NONE)
        self._is_next = np.zeros(env.settings.robots, np.bool_)

    def steps_left(self, battery: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the steps that batteries last."""
        return battery / self._cost

    def reserve(self, ways: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return the steps that a battery must last for ways of so many cells to a charger.

        It is at most what a battery with ``ENOUGH`` lasts.
        """
        return np.minimum(DETOUR * ways + SPARE_STEPS, ENOUGH * self._capacity / self._cost)

    def update(
        self,
        cells: Integers,
        battery: NDArray[np.float64],
        may_go: NDArray[np.bool_],
        limits: NDArray[np.float64],
    ) -> None:
        """End the turns of robots that have charged, and give turns to others.

        Args:
            cells: ``[R]``, where they are.
            battery: ``[R]`` units left; robots without any have no turn.
            may_go: ``[R]``, whether they may go to charge now.
            limits: ``[R]``, the share of a full battery below which a robot goes to a charger that
                nobody uses.
        """
        if not len(self.cells):
            return
        is_blocked = np.isin(self.cells, cells[battery <= 0])
        is_over = (battery >= self._full) | (battery <= 0) | is_blocked[self.turn]
        self.turn[is_over] = NONE
        holder = self._holders()
        until = self._until(holder, cells, battery)
        counts = np.bincount(self.turn + 1, minlength=len(holder) + 1)[1:]
        self._give_turns(
            self._low(until, cells, battery),
            (counts < 2) & ~is_blocked,
            until,
            cells,
            battery,
            may_go,
        )
        counts = np.bincount(self.turn + 1, minlength=len(holder) + 1)[1:]
        low = np.flatnonzero((battery < limits * self._capacity) & (self.turn == NONE))
        self._give_turns(low, (counts == 0) & ~is_blocked, until, cells, battery, may_go)
        self._is_next = (self.turn != NONE) & (holder[self.turn] != NONE)
        self._is_next[holder[holder != NONE]] = False

    def goals(self, cells: Integers) -> NDArray[np.intp]:
        """Return the cell that each robot with a turn is to go to, ``[R]``, or ``NONE``."""
        goals = np.full(len(cells), NONE)
        robots = np.flatnonzero(self.turn != NONE)
        chargers = self.turn[robots]
        is_taken = np.isin(self.cells, cells)[chargers] | self._is_next[robots]
        waits = is_taken & (self._ways[chargers, cells[robots]] <= QUEUE_DISTANCE)
        waits &= cells[robots] != self.cells[chargers]
        goals[robots] = np.where(waits, cells[robots], self.cells[chargers])
        return goals

    def _holders(self) -> Integers:
        """Return the robot that has each charger, ``[C]``; who came next has it when it is free."""
        holder = np.full(len(self.cells), NONE)
        for is_next in (True, False):
            robots = np.flatnonzero((self.turn != NONE) & (self._is_next == is_next))
            holder[self.turn[robots]] = robots
        self._is_next[holder[holder != NONE]] = False
        return holder

    def _until(
        self, holder: Integers, cells: Integers, battery: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the steps until each charger is free, ``[C]``."""
        until = np.zeros(len(holder))
        used = np.flatnonzero(holder != NONE)
        robots = holder[used]
        ways = self._ways[used, cells[robots]]
        missing = self._full - battery[robots] + self._cost * ways
        until[used] = ways + np.maximum(missing, 0) / self._gain
        return until

    def _low(
        self, until: NDArray[np.float64], cells: Integers, battery: NDArray[np.float64]
    ) -> NDArray[np.intp]:
        """Return the robots that are to charge now, those whose batteries last shortest first."""
        robots = np.flatnonzero((self.turn == NONE) & (battery > 0))
        home = DETOUR * self.home[cells[robots]]
        spare = self.steps_left(battery[robots]) - home
        first = np.argsort(spare, kind="stable")
        turns = self._turns(home, battery[robots])[first]
        coming = np.flatnonzero(self._is_next & (self.turn != NONE))
        begun = until.sum() + self._turns(DETOUR * self.home[cells[coming]], battery[coming]).sum()
        # While a robot waits, its battery loses what makes its turn longer.
        count = len(self.cells)
        growth = (1 + self._cost / self._gain / count) ** np.arange(len(robots))
        waiting = growth * (begun + np.cumsum(turns / growth) - turns[:1]) / count
        late = np.flatnonzero(spare[first] < MARGIN * waiting + SPARE_STEPS)
        found: NDArray[np.intp] = robots[first[: late[-1] + 1 if len(late) else 0]]
        return found

    def _turns(
        self, home: NDArray[np.float64], battery: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the steps for which robots will have their chargers."""
        missing = self._full - battery + self._cost * home
        return GAP + np.maximum(missing, 0) / self._gain

    def _give_turns(
        self,
        robots: Integers,
        has_room: NDArray[np.bool_],
        until: NDArray[np.float64],
        cells: Integers,
        battery: NDArray[np.float64],
        may_go: NDArray[np.bool_],
    ) -> None:
        """Give turns at chargers, so that the sum of the steps until they begin is least."""
        robots, slots = robots[may_go[robots]], np.flatnonzero(has_room)
        if not (len(robots) and len(slots)):
            return
        ways = self._ways[slots][:, cells[robots]].T
        waits = np.maximum(until[slots] - DETOUR * ways, 0)
        home = self.home[cells[robots]]
        spare = self.steps_left(battery[robots]) - DETOUR * home
        must = spare < SPARE_STEPS
        allowed = (waits <= PATIENCE) & (ways <= home[:, None] + NEARBY)
        allowed |= np.isfinite(ways) & must[:, None]
        costs = ways + waits + WEIGHT * spare[:, None]
        chosen = linear_sum_assignment(np.where(allowed, costs, 1e9))
        for robot, slot in zip(*chosen, strict=True):
            if allowed[robot, slot]:
                self.turn[robots[robot]] = slots[slot]
