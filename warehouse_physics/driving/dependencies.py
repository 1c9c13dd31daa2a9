"""Who passes each cell before whom: the dependencies between the moves of a joint plan.

A plan says in which step each robot moves. Bodies need other times than a plan has, but the same
order: a robot may enter a cell once the robot that is to be there before it moves on. Robots that
keep to this order meet nobody whom the plan does not let them meet, however late they are.

Nodes are the cells of a robot's way, numbered from 0, without the steps in which it waits. Rings,
in which three or more robots move into one another's cells, are nodes that depend on each other;
they are released together by moving together, each as the one before it moves on.

A robot that fails never leaves its cell. ``cut`` discards the nodes that nobody can reach any more,
so that all others can go on from where their ways then end.

Source: Hönig, Kiesel, Tinka, Durham and Ayanian (2019), Persistent and robust execution of MAPF
schedules in warehouses, IEEE Robotics and Automation Letters 4 (2): the Action Dependency Graph.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from warehouse_core.world.tiles import Cell

HISTORY = 10
"""Nodes of a way that are kept behind a robot, which may have to go back after a failure."""


class Visit(NamedTuple):
    """A node: ``robot`` is in a cell as the node ``number`` of its way."""

    robot: int
    number: int


class WayCell(NamedTuple):
    """A cell of a way, and the visits of other robots that have to end before it is entered.

    There is at most one, but after failures, when a robot that goes back may still reach into the
    cell of another.
    """

    cell: Cell
    after: tuple[Visit, ...] = ()


class Dependencies:
    """The ways of ``R`` robots, at first in different cells, and the order in which they pass."""

    def __init__(self, cells: Sequence[Cell]) -> None:
        self._ways = [deque([WayCell(cell)]) for cell in cells]
        self._firsts = [0] * len(cells)
        self._latest: dict[Cell, tuple[Visit, ...]] = {
            cell: (Visit(robot, 0),) for robot, cell in enumerate(cells)
        }

    def first(self, robot: int) -> int:
        """Return the number of the first node of a way that has not been forgotten."""
        return self._firsts[robot]

    def last(self, robot: int) -> int:
        """Return the number of the last node of a way."""
        return self._firsts[robot] + len(self._ways[robot]) - 1

    def end(self, robot: int) -> Cell:
        """Return the last cell of a way."""
        return self._ways[robot][-1].cell

    def node(self, robot: int, number: int) -> WayCell:
        """Return a node; raise ``LookupError`` if it is not there yet, or has been forgotten."""
        place = number - self._firsts[robot]
        if not 0 <= place < len(self._ways[robot]):
            raise LookupError(
                f"robot {robot} has no node {number}; its nodes are {self._firsts[robot]} to "
                f"{self.last(robot)}"
            )
        return self._ways[robot][place]

    def move(self, robot: int, number: int) -> Cell:
        """Return the displacement that leads to a node from the one before it."""
        (row, col), (to_row, to_col) = (
            self.node(robot, each).cell for each in (number - 1, number)
        )
        return to_row - row, to_col - col

    def nodes(self, robot: int, first: int) -> Iterator[tuple[int, WayCell]]:
        """Yield the nodes of a way from ``first`` on, with their numbers.

        The first node that has not been forgotten, where the robot has been, is not among them.
        """
        for number in range(max(first, self._firsts[robot] + 1), self.last(robot) + 1):
            yield number, self.node(robot, number)

    def extend(self, targets: Sequence[Cell]) -> list[int]:
        """Append a joint step, and return the robots that move in it.

        Targets are the next cells, or the ends of the ways of robots that wait. All are different,
        and no two robots change places.
        """
        movers = [robot for robot, cell in enumerate(targets) if cell != self.end(robot)]
        before = [self._latest.get(targets[robot], ()) for robot in movers]
        for robot, visits in zip(movers, before, strict=True):
            after = tuple(visit for visit in visits if visit.robot != robot)
            self._ways[robot].append(WayCell(targets[robot], after))
            self._latest[targets[robot]] = (Visit(robot, self.last(robot)),)
        return movers

    def forget(self, robot: int, number: int) -> None:
        """Forget the nodes of a way that are far before ``number``, which it has passed."""
        for first in range(self._firsts[robot], number - HISTORY):
            cell, visit = self._ways[robot].popleft().cell, Visit(robot, first)
            self._firsts[robot] = first + 1
            if self._latest.get(cell) == (visit,):
                del self._latest[cell]  # nobody has to wait for it any more

    def cut(
        self, robot: int, number: int, reached: Sequence[int], present: Sequence[int]
    ) -> dict[int, bool]:
        """Discard the nodes that cannot be reached any more, as a robot has failed.

        Nobody else enters its cells, and all ways end in different cells, except where two robots
        have failed between the same two cells. A robot that cannot stop before a node that is
        discarded drives on until it rests, and goes back: the nodes that lead back are appended to
        its way, in the order in which the robots behind it leave them. It cannot go back if a robot
        that has failed reaches into one of these cells.

        Args:
            robot: robot that stays at the node ``number``, or between it and the next.
            number: node of this robot.
            reached: ``[R]``, nodes that robots are at, or cannot stop before.
            present: ``[R]``, first node of each way whose cell the robot has not left.

        Returns:
            The other robots whose ways have changed, and whether they go back.
        """
        follower = {
            visit: Visit(each, at)
            for each in range(len(self._ways))
            for at, node in self.nodes(each, 0)
            for visit in node.after
        }
        keep = self._reachable(robot, number, follower)
        changed = {
            each: reached[each] > last
            for each, last in enumerate(keep)
            if last < self.last(each) and each != robot
        }

        def after(each: int, at: int) -> tuple[Visit, ...]:
            """Return the visit that ends before a robot goes back to its node ``at``, if any."""
            behind = follower.get(Visit(each, at))
            if behind is None or behind.number > reached[behind.robot]:
                return ()
            if not changed.get(behind.robot):  # the one that has failed, and reaches into this cell
                return ()
            return (Visit(behind.robot, 2 * reached[behind.robot] - behind.number),)

        backwards = [each for each, goes_back in changed.items() if goes_back]
        ways = [
            # It waits for nobody on the way to where it rests, which is before the last of these.
            [WayCell(self.node(each, at).cell) for at in range(keep[each] + 1, reached[each] + 1)]
            + [
                WayCell(self.node(each, at).cell, after(each, at))
                for at in range(reached[each] - 1, keep[each] - 1, -1)
            ]
            for each in backwards
        ]
        for each in {robot, *changed}:
            while self.last(each) > keep[each]:
                self._ways[each].pop()
        for each, way in zip(backwards, ways, strict=True):
            self._ways[each].extend(way)
        self._find_latest(present)
        return changed

    def _reachable(self, robot: int, number: int, follower: dict[Visit, Visit]) -> list[int]:
        """Return the last node that each robot can reach if one stays at a node."""
        keep = [self.last(each) for each in range(len(self._ways))]
        ends = [(robot, number)]
        while ends:
            each, last = ends.pop()
            last = max(last, self._firsts[each])
            for at in range(last, keep[each] + 1):
                behind = follower.get(Visit(each, at))
                if behind and behind.number <= keep[behind.robot]:
                    ends.append((behind.robot, behind.number - 1))
            keep[each] = min(keep[each], last)
        return keep

    def _find_latest(self, present: Sequence[int]) -> None:
        """Find the last visits of each cell, of the nodes from ``present`` on."""
        visits: dict[Cell, list[Visit]] = {}
        earlier: set[Visit] = set()
        for robot, way in enumerate(self._ways):
            own: dict[Cell, Visit] = {}
            for number, node in enumerate(way, self._firsts[robot]):
                if number >= min(present[robot], self.last(robot)):
                    earlier.update(node.after)
                    if node.cell in own:
                        earlier.add(own[node.cell])
                    own[node.cell] = visit = Visit(robot, number)
                    visits.setdefault(node.cell, []).append(visit)
        self._latest = {
            cell: tuple(visit for visit in found if visit not in earlier)
            for cell, found in visits.items()
        }
