"""Which robot does which task: a cheapest matching, made anew whenever a plan is asked for.

A robot may change its task until it has visited the first cell of it. ``R`` is the number of
robots.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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

Beyond it only robots without a task get one, so many robots at a time.
"""

BUSY, BUSY_BY_FREE = 0.27, 2
"""Most robots with tasks at a time, as a share of the open cells and of those without a robot."""

KEEP = 1.0
"""Steps by which another task must be shorter before a robot changes its task."""


def most_busy(open_cells: int, robots: int) -> int:
    """Return how many robots are to have tasks at a time; more would block one another.

    Example:
        >>> from agents.mapf.league.scheduler import most_busy
        >>> most_busy(open_cells=819, robots=400), most_busy(open_cells=819, robots=800)
        (221, 38)
    """
    return max(1, min(int(BUSY * open_cells), BUSY_BY_FREE * (open_cells - robots)))


class Scheduler:
    """Gives tasks to robots so that the sum of their lengths is least.

    The length of a task is the distance of the robot to its first cell, turns included, and from
    there through its other cells. On crowded floors robots without a task give way to others.

    Args:
        graph: floor, of which only the cells are used.
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
        self._graph = graph.with_costs()
        headed = graph.with_costs(None, 1.0)
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
        taken = set(schedule[begun].tolist())
        if len(robots) * (len(known) - len(taken)) > MAX_PAIRS:
            robots, taken = np.flatnonzero(schedule == NO_TASK), set(schedule.tolist())
        open_tasks = [task for task in known.values() if task.number not in taken]
        busy = int((np.delete(schedule, robots) != NO_TASK).sum())
        room = most_busy(len(self._graph.layout.open_cells), len(cells)) - busy
        for some in self._portions(robots, len(open_tasks)):
            costs = self._lengths(cells[some], headings[some], open_tasks)
            column = {task.number: index for index, task in enumerate(open_tasks)}
            held = np.array([column.get(task, NO_TASK) for task in schedule[some].tolist()])
            has = np.flatnonzero(held != NO_TASK)
            costs[has, held[has]] -= KEEP
            schedule[some] = NO_TASK
            rows, columns = cheapest_matching(costs)
            shortest = np.argsort(costs[rows, columns], kind="stable")[: max(0, room)]
            rows, columns = rows[shortest], columns[shortest]
            room -= len(rows)
            numbers = np.array([task.number for task in open_tasks])
            schedule[some[rows]] = numbers[columns]
            gone = set(columns.tolist())
            open_tasks = [task for index, task in enumerate(open_tasks) if index not in gone]
        return schedule

    def _portions(self, robots: Integers, tasks: int) -> Iterator[Integers]:
        """Yield the robots, so many at a time as are in one matching."""
        size = max(1, MAX_PAIRS // max(1, tasks))
        for start in range(0, len(robots), size):
            yield robots[start : start + size]

    def _lengths(
        self, cells: Integers, headings: Integers, tasks: list[LeagueTask]
    ) -> NDArray[np.float64]:
        """Return the lengths of tasks for robots, ``[robots, tasks]``."""
        firsts = np.array([task.cells[0] for task in tasks], np.intp)
        trips = np.array([self._trip(task.cells) for task in tasks])
        if self._fields is None:
            ways = self._between(cells[:, None], firsts[None, :]).astype(np.float64)
        else:
            rows, size = self._fields.rows(firsts), self._graph.size
            ways = self._fields.matrix[rows[None, :], (headings * size + cells)[:, None]]
            ways = ways / self._fields.step
        found: NDArray[np.float64] = ways + trips
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
