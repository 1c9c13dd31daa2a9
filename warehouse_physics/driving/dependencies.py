"""Which robot passes each cell before which: dependencies between the moves of a joint plan.

A plan says in which step each robot moves. Bodies take other times than the steps of a plan, but
they can keep its order: a robot may enter a cell once the robot that is there before it has moved
on. Robots that keep this order cannot collide, however late they are.

The nodes of a robot are the cells of its route, numbered from 0, without the steps in which it
waits. In a ring, three or more robots move into each other's cells, so their nodes depend on each
other in a circle. They can still move, because all of them leave at the same time.

A robot that fails never leaves its cell. ``cut`` then discards the nodes that no robot can reach
any more. The other robots can go on from the ends of the routes that remain.

Source: Hönig, Kiesel, Tinka, Durham and Ayanian (2019), Persistent and robust execution of MAPF
schedules in warehouses, IEEE Robotics and Automation Letters 4 (2): the Action Dependency Graph.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from warehouse_core.world.tiles import Cell

HISTORY = 10
"""Number of nodes kept behind each robot, since it may have to go back after a failure."""


class Visit(NamedTuple):
    """A node: the stay of ``robot`` in the cell that has this ``number`` in its route."""

    robot: int
    number: int


class RouteCell(NamedTuple):
    """A cell of a route, and the visits of other robots that have to end before it is entered.

    There is at most one such visit, except after failures. A robot that goes back may then still
    reach into the cell of another one.
    """

    cell: Cell
    after: tuple[Visit, ...] = ()


class Dependencies:
    """The routes of ``R`` robots, and the order in which robots pass each cell.

    At first each robot has a route of one cell, and all these cells are different.
    """

    def __init__(self, cells: Sequence[Cell]) -> None:
        self._routes = [deque([RouteCell(cell)]) for cell in cells]
        self._firsts = [0] * len(cells)
        self._latest: dict[Cell, tuple[Visit, ...]] = {
            cell: (Visit(robot, 0),) for robot, cell in enumerate(cells)
        }

    def first(self, robot: int) -> int:
        """Return the number of the first node of a route that is still known."""
        return self._firsts[robot]

    def last(self, robot: int) -> int:
        """Return the number of the last node of a route."""
        return self._firsts[robot] + len(self._routes[robot]) - 1

    def end(self, robot: int) -> Cell:
        """Return the last cell of a route."""
        return self._routes[robot][-1].cell

    def node(self, robot: int, number: int) -> RouteCell:
        """Return a node of a route.

        Raises:
            LookupError: the route does not have this node yet, or the node has been forgotten.
        """
        place = number - self._firsts[robot]
        if not 0 <= place < len(self._routes[robot]):
            raise LookupError(
                f"robot {robot} has no node {number}; its nodes are {self._firsts[robot]} to "
                f"{self.last(robot)}"
            )
        return self._routes[robot][place]

    def move(self, robot: int, number: int) -> Cell:
        """Return the displacement to a node from the node before it."""
        (row, col), (to_row, to_col) = (
            self.node(robot, each).cell for each in (number - 1, number)
        )
        return to_row - row, to_col - col

    def nodes(self, robot: int, first: int) -> Iterator[tuple[int, RouteCell]]:
        """Yield the numbers and the nodes of a route from node ``first`` on.

        The oldest node that is known is left out, because the robot has already been there.
        """
        for number in range(max(first, self._firsts[robot] + 1), self.last(robot) + 1):
            yield number, self.node(robot, number)

    def extend(self, targets: Sequence[Cell]) -> list[int]:
        """Append a joint step to the routes, and return the robots that move in it.

        ``targets`` has the next cell of each robot, or the end of its route if it waits. The cells
        must be different, and no two robots may swap places.
        """
        movers = [robot for robot, cell in enumerate(targets) if cell != self.end(robot)]
        before = [self._latest.get(targets[robot], ()) for robot in movers]
        for robot, visits in zip(movers, before, strict=True):
            after = tuple(visit for visit in visits if visit.robot != robot)
            self._routes[robot].append(RouteCell(targets[robot], after))
            self._latest[targets[robot]] = (Visit(robot, self.last(robot)),)
        return movers

    def forget(self, robot: int, number: int) -> None:
        """Forget the nodes that are far behind ``number``, which the robot has passed."""
        for first in range(self._firsts[robot], number - HISTORY):
            cell, visit = self._routes[robot].popleft().cell, Visit(robot, first)
            self._firsts[robot] = first + 1
            if self._latest.get(cell) == (visit,):
                del self._latest[cell]  # no robot has to wait for it any more

    def cut(
        self, robot: int, number: int, reached: Sequence[int], present: Sequence[int]
    ) -> dict[int, bool]:
        """Discard the nodes that can no longer be reached because a robot has failed.

        Afterwards no other robot enters the cells of this robot. All routes end in different cells,
        except where two robots have failed between the same two cells.

        A robot that cannot stop before a discarded node drives on until it is at rest, and then
        goes back. The nodes of its return are appended to its route, and it enters each of these
        cells after the robot behind it has left. It cannot go back if a failed robot reaches into
        one of the cells.

        Args:
            robot: robot that stays at the node ``number``, or between this node and the next.
            number: node of this robot.
            reached: ``[R]``, last node of each robot that it is at or cannot stop before.
            present: ``[R]``, first node of each route whose cell the robot has not left.

        Returns:
            The other robots whose routes have changed, and whether each of them goes back.
        """
        follower = {
            visit: Visit(each, at)
            for each in range(len(self._routes))
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
            """Return the visits that must end before a robot goes back to its node ``at``."""
            behind = follower.get(Visit(each, at))
            if behind is None or behind.number > reached[behind.robot]:
                return ()
            if not changed.get(behind.robot):  # it has failed, and reaches into this cell
                return ()
            return (Visit(behind.robot, 2 * reached[behind.robot] - behind.number),)

        backwards = [each for each, goes_back in changed.items() if goes_back]
        returns = [
            # It waits for no robot before it is at rest, which is before the last of these nodes.
            [RouteCell(self.node(each, at).cell) for at in range(keep[each] + 1, reached[each] + 1)]
            + [
                RouteCell(self.node(each, at).cell, after(each, at))
                for at in range(reached[each] - 1, keep[each] - 1, -1)
            ]
            for each in backwards
        ]
        for each in {robot, *changed}:
            while self.last(each) > keep[each]:
                self._routes[each].pop()
        for each, nodes in zip(backwards, returns, strict=True):
            self._routes[each].extend(nodes)
        self._find_latest(present)
        return changed

    def _reachable(self, robot: int, number: int, follower: dict[Visit, Visit]) -> list[int]:
        """Return the last node that each robot can reach if ``robot`` stays at ``number``."""
        keep = [self.last(each) for each in range(len(self._routes))]
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
        """Find the last visits to each cell, among the nodes from ``present`` on."""
        visits: dict[Cell, list[Visit]] = {}
        earlier: set[Visit] = set()
        for robot, route in enumerate(self._routes):
            own: dict[Cell, Visit] = {}
            for number, node in enumerate(route, self._firsts[robot]):
                if number >= min(present[robot], self.last(robot)):
                    earlier.update(node.after)
                    if node.cell in own:
                        earlier.add(own[node.cell])
                    own[node.cell] = visit = Visit(robot, number)
                    visits.setdefault(node.cell, []).append(visit)
        self._latest = {
            cell: tuple(visit for visit in of_cell if visit not in earlier)
            for cell, of_cell in visits.items()
        }
