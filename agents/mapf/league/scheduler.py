"""Which robot does which task: a cheapest matching, made anew whenever a plan is asked for.

A robot may change its task until it has visited the first cell of it. ``R`` is the number of
robots.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Fields, Graph
from agents.mapf.league.tasks import NO_TASK, LeagueTask
from agents.mapf.matching import cheapest_matching
from warehouse_core.world.tables import Integers

__all__ = ["Scheduler", "most_busy"]

MAX_FIELD_BYTES = 128_000_000
"""Most memory for distances to the first cells of tasks; beyond it Manhattan distances serve."""

MAX_PAIRS = 1_000_000
"""Most pairs of robots and tasks in a matching.

Beyond it only robots without a task get one, in several matchings.
"""

CROWD = 2000
"""Robots above which planning in windows takes too long."""

FULL = 0.8
"""Robots for each open cell above which a floor is full: all have tasks there, since who has none
joins in no ring of robots that move at once.
"""

BUSY_BY_CELL, BUSY_BY_ROBOT = 0.2275, 0.19
"""Most robots with tasks at a time for each open cell, and more of them for each robot."""

BUSY_IN_CROWD = 0.185
"""Most robots with tasks at a time for each open cell, of a crowd."""

MAX_COMING = 9
"""Most robots on their way to a cell where tasks begin; more would block those that leave it."""

TRIP_WEIGHT = 0.1
"""Weight of the way from the first to the last cell of a task where only robots without a task get
one. Those tasks are a few of all that are to be done, and robots had better take one that is near.
"""

KEEP = 1.0
"""Steps by which another task must be shorter before a robot changes its task."""


def most_busy(open_cells: int, robots: int) -> int:
    """Return how many robots are to have tasks at a time; more would block one another.

    On a floor that is full it is how many go first, see ``entry.py``.

    Example:
        >>> from agents.mapf.league.scheduler import most_busy
        >>> most_busy(open_cells=819, robots=400), most_busy(open_cells=819, robots=800)
        (262, 338)
        >>> most_busy(open_cells=38_586, robots=10_000)
        7138
    """
    most = BUSY_BY_CELL * open_cells + BUSY_BY_ROBOT * robots
    if robots > CROWD:
        most = min(BUSY_IN_CROWD * open_cells, open_cells - robots)
    return max(1, int(most))


def is_full(open_cells: int, robots: int) -> bool:
    """Return whether a floor is full; see ``FULL``. With more than ``CROWD`` robots it is not."""
    return FULL * open_cells < robots <= CROWD


class Scheduler:
    """Gives tasks to robots so that the sum of their lengths is least.

    The length of a task is the distance of the robot to its first cell, turns included, and from
    there through its other cells. On crowded floors robots without a task give way to others.

    Args:
        graph: floor, with costs of moves as the planner of the robots has them.
        tasks: most tasks that are known at a time.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.league.scheduler import Scheduler
        >>> from agents.mapf.league.tasks import LeagueTask
        >>> from warehouse_core import Layout
        >>> known = {7: LeagueTask(7, (4, 0), revealed=0), 8: LeagueTask(8, (1,), revealed=0)}
        >>> scheduler = Scheduler(Graph(Layout([".....", "....."])), tasks=2)
        >>> scheduler.assign(np.array([3, 0]), np.array([1, 1]), known, np.array([-1, -1]))
        array([7, 8])
    """

    def __init__(self, graph: Graph, tasks: int) -> None:
        self._graph = graph.with_costs(graph.costs)
        headed = graph.with_costs(graph.costs, 1.0)
        fits = headed.places * tasks * np.dtype(np.int32).itemsize <= MAX_FIELD_BYTES
        self._fields = Fields(headed) if fits else None
        self._trip = cache(self._trip_of)

    def assign(
        self,
        cells: Integers,
        headings: Integers,
        known: Mapping[int, LeagueTask],
        schedule: Integers,
    ) -> Integers:
        """Return the task of each robot, ``[R]``, or ``NO_TASK``.

        Args:
            cells: ``[R]``, cells of the robots.
            headings: ``[R]``, their headings.
            known: tasks that are not finished, by number.
            schedule: ``[R]``, the tasks that the robots have.
        """
        schedule = schedule.copy()
        begun = np.array(
            [task != NO_TASK and known[task].visited > 0 for task in schedule.tolist()]
        )
        robots = np.flatnonzero(~begun)
        taken, weight = set(schedule[begun].tolist()), 1.0
        if len(robots) * (len(known) - len(taken)) > MAX_PAIRS:
            robots, taken = np.flatnonzero(schedule == NO_TASK), set(schedule.tolist())
            weight = TRIP_WEIGHT
        tasks = self._open_tasks(known, taken)
        busy = int((np.delete(schedule, robots) != NO_TASK).sum())
        size = len(self._graph.layout.open_cells), len(cells)
        room = (len(cells) if is_full(*size) else most_busy(*size)) - busy
        held = schedule.copy()
        schedule[robots] = NO_TASK
        while len(robots) and tasks and room > 0:
            if len(robots) < len(tasks):
                some, few = robots[: max(1, MAX_PAIRS // len(tasks))], tasks
            else:
                some, few = robots, tasks[: max(1, MAX_PAIRS // len(robots))]
            numbers = np.array([task.number for task in few])
            costs = self._lengths(cells[some], headings[some], few, weight)
            costs[held[some, None] == numbers] -= KEEP
            rows, columns = cheapest_matching(costs)
            shortest = np.argsort(costs[rows, columns], kind="stable")[:room]
            rows, columns = some[rows[shortest]], numbers[columns[shortest]]
            schedule[rows] = columns
            robots, given = np.setdiff1d(robots, rows), set(columns.tolist())
            tasks = [task for task in tasks if task.number not in given]
            room -= len(rows)
        return schedule

    def _open_tasks(self, known: Mapping[int, LeagueTask], taken: set[int]) -> list[LeagueTask]:
        """Return the tasks that are not taken, in order of their numbers.

        Of those with the same first cell, only so many with the shortest trips are returned that
        ``MAX_COMING`` robots are on their way to it.
        """
        coming = Counter(
            known[number].cells[0]
            for number in taken
            if number in known and not known[number].visited
        )
        found = []
        for task in sorted(known.values(), key=lambda task: self._trip(task.cells)):
            if task.number not in taken and coming[task.cells[0]] < MAX_COMING:
                coming[task.cells[0]] += 1
                found.append(task)
        return sorted(found, key=lambda task: task.number)

    def _lengths(
        self, cells: Integers, headings: Integers, tasks: list[LeagueTask], weight: float
    ) -> NDArray[np.float64]:
        """Return the lengths of tasks for robots, ``[robots, tasks]``; trips have a weight."""
        firsts = np.array([task.cells[0] for task in tasks], np.intp)
        trips = np.array([self._trip(task.cells) for task in tasks])
        if self._fields is None:
            ways = self._between(cells[:, None], firsts[None, :]).astype(np.float64)
        else:
            rows, size = self._fields.rows(firsts), self._graph.size
            ways = self._fields.matrix[rows[None, :], (headings * size + cells)[:, None]]
            ways = ways / self._fields.step
        found: NDArray[np.float64] = ways + weight * trips
        return found

    def _trip_of(self, cells: tuple[int, ...]) -> float:
        """Return the distance from the first through the last cell of a task."""
        if self._fields is None:
            return float(sum(self._between(*map(np.array, pair)) for pair in pairwise(cells)))
        return float(sum(self._graph.distances(end)[start] for start, end in pairwise(cells)))

    def _between(self, starts: Integers, ends: Integers) -> Integers:
        """Return Manhattan distances."""
        width = self._graph.layout.width
        rows, columns = np.divmod(starts, width)
        far_rows, far_columns = np.divmod(ends, width)
        steps: Integers = np.abs(rows - far_rows) + np.abs(columns - far_columns)
        return steps
