"""The order in which robots pass the cells of a joint plan, kept by robots that are late or early.

A joint plan says in which step each robot moves. Robots that go on as soon as those before them in
the next cell have left it meet nobody whom the plan does not let them meet, whatever time they
take, and do not wait for a time. See ``warehouse_physics/driving/dependencies.py`` for bodies.
"""

from __future__ import annotations

from collections.abc import Iterable
from copy import deepcopy

import numpy as np

from warehouse_core.world.tables import Integers


class PassingOrder:
    """The ways of ``R`` robots in a joint plan, and who passes each cell before whom.

    Args:
        cells: ``[R, T]``, cell of each robot at each time, without conflicts.

    Attributes:
        ways: cells of each robot, from the one where it is to the last.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.passing import PassingOrder
        >>> order = PassingOrder(np.array([[1, 2, 3], [0, 0, 1]]))
        >>> order.movers([1]), order.movers([0, 1])
        ([], [0, 1])
    """

    def __init__(self, cells: Integers) -> None:
        self.ways: list[list[int]] = [[cell] for cell in cells[:, 0].tolist()]
        self._robots_of = {way[0]: [robot] for robot, way in enumerate(self.ways)}
        times, robots = np.nonzero(np.diff(cells, axis=1).T)
        for time, robot in zip(times.tolist(), robots.tolist(), strict=True):
            cell = int(cells[robot, time + 1])
            self.ways[robot].append(cell)
            self._robots_of.setdefault(cell, []).append(robot)

    def movers(self, robots: Iterable[int]) -> list[int]:
        """Return which of some robots may go on now, if all of these do it together."""
        before = {}
        for robot in robots:
            if len(way := self.ways[robot]) > 1:
                first, *others = self._robots_of[way[1]]
                if first == robot:
                    before[robot] = robot  # the cell is empty
                elif others[0] == robot and self.ways[first][0] == way[1]:
                    before[robot] = first
        while waiting := [robot for robot, first in before.items() if first not in before]:
            for robot in waiting:
                del before[robot]
        return list(before)

    def move(self, robots: Iterable[int]) -> None:
        """Let robots go on that may do it together."""
        for robot in robots:
            self._robots_of[self.ways[robot].pop(0)].pop(0)

    def cells(self) -> list[int]:
        """Return the cell where each robot is."""
        return [way[0] for way in self.ways]

    def plan(self, steps: int, late: Iterable[int]) -> Integers:
        """Return the cells from now on, ``[R, steps + 1]``, if all go on as soon as they may.

        Robots that are ``late`` stay in the first step.
        """
        order, everybody = deepcopy(self), range(len(self.ways))
        found, able = [order.cells()], set(everybody).difference(late)
        for _ in range(steps):
            order.move(order.movers(sorted(able)))
            found.append(order.cells())
            able = set(everybody)
        return np.array(found).T
