"""The tasks of the League: how they are revealed, given to robots, and finished.

A task is a sequence of cells, which one robot visits in turn: its errands. Tasks are numbered as
they are revealed; the file of a problem begins again after its last. ``R`` is the number of robots.

Source: ``src/TaskManager.cpp`` of the League's Start-Kit, 2.1.2 and 3.1.0, and
``src/CompetitionSystem.cpp`` of 1.1.5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

import numpy as np

from agents.mapf.league.rules import NOBODY
from warehouse_core.world.robot_runners import FIXED, GREEDY, League
from warehouse_core.world.tables import Integers

__all__ = ["LeagueTask"]

NO_TASK = -1


@dataclass
class LeagueTask:
    """A task that has been revealed.

    Attributes:
        number: number of the task.
        cells: numbers of the cells to visit.
        revealed: step at which it became known.
        visited: number of its cells that have been visited; the task is open to its robot alone
            once it is not 0.
        robot: robot that has it, or ``NOBODY``.

    Example:
        >>> from agents.mapf.league.tasks import LeagueTask
        >>> task = LeagueTask(7, (4, 0), revealed=0, visited=1)
        >>> task.goal, task.is_finished
        (0, False)
    """

    number: int
    cells: tuple[int, ...]
    revealed: int
    visited: int = 0
    robot: int = NOBODY

    @property
    def goal(self) -> int:
        """The cell to visit next."""
        return self.cells[self.visited]

    @property
    def is_finished(self) -> bool:
        """Whether all cells have been visited."""
        return self.visited == len(self.cells)


class Errand(NamedTuple):
    """A visit to a cell of a task, after which ``visited`` of its cells are done."""

    step: int
    robot: int
    task: int
    visited: int


class ScheduleError(NamedTuple):
    """Why a schedule is not taken as it is; ``robot`` and ``other`` may be ``NOBODY``."""

    task: int
    robot: int
    other: int
    step: int
    text: str


class TaskPool:
    """Tasks that are known, and which robot has which.

    Args:
        problem: problem of 2024 or 2026.

    Attributes:
        tasks: all tasks that have been revealed.
        known: tasks that are not finished, by number.
        schedule: ``[R]``, the task of each robot, or ``NO_TASK``.
        given: ``[R]`` lists of pairs: the step at which a robot's task changed, and the new task.
        errands: visits so far.
        errors: errors of schedules so far.
        finished: number of finished tasks.
    """

    def __init__(self, problem: League) -> None:
        numbers = problem.layout.numbers
        self._source = [tuple(numbers(task).tolist()) for task in problem.tasks]
        self._revealed, self._repairs = problem.revealed, problem.year == 2026
        robots = len(problem.starts)
        self.tasks: list[LeagueTask] = []
        self.known: dict[int, LeagueTask] = {}
        self.schedule: Integers = np.full(robots, NO_TASK)
        self.given: list[list[tuple[int, int]]] = [[] for _ in range(robots)]
        self.errands: list[Errand] = []
        self.errors: list[ScheduleError] = []
        self.finished = 0
        self._goals = np.full(robots, NO_TASK)
        self.reveal(0)

    def goals(self, cells: Integers) -> Integers:
        """Return the cell that each robot is to visit next, its own if it has no task."""
        return np.where(self._goals == NO_TASK, cells, self._goals)

    def propose(self, schedule: Integers, step: int) -> None:
        """Take a schedule, ``[R]`` tasks or ``NO_TASK``.

        In 2024 a schedule with an error is dropped; in 2026 the robots that have one lose their
        tasks, or keep those that they have begun.
        """
        robots = len(self.schedule)
        if len(schedule) != robots:
            text = "Invalid schedule size"
            self.errors.append(ScheduleError(NO_TASK, NOBODY, NOBODY, step, text))
            return
        if np.array_equal(schedule, self.schedule):
            return
        taken: dict[int, int] = {}
        wanted = schedule.copy()
        for robot, task in enumerate(schedule.tolist()):
            if error := self._error(robot, task, taken):
                other, text, instead = error
                self.errors.append(ScheduleError(task, robot, other, step, text))
                if not self._repairs:
                    return
                wanted[robot] = instead
            taken[int(wanted[robot])] = robot
        changed = np.flatnonzero(wanted != self.schedule).tolist()
        for robot in changed:
            if (task := int(self.schedule[robot])) != NO_TASK:
                self.known[task].robot = NOBODY
        for robot in changed:
            self._give(robot, int(wanted[robot]), step)

    def _error(self, robot: int, task: int, taken: dict[int, int]) -> tuple[int, str, int] | None:
        """Return another robot, the error of a robot and a task, and its task instead."""
        held = self.known.get(int(self.schedule[robot]))
        if held and held.visited and task != held.number:
            return (
                NOBODY,
                "schedule agent to another task who is already opened a task",
                held.number,
            )
        if task == NO_TASK:
            return None
        if task not in self.known:
            return NOBODY, "task already finished", NO_TASK
        if task in taken:
            text = "task is already assigned by the second agent at the same time"
            return taken[task], text, NO_TASK
        owner = self.known[task].robot
        if self.known[task].visited and owner != robot:
            return owner, "task is already opened by other agent", NO_TASK
        return None

    def _give(self, robot: int, task: int, step: int) -> None:
        self.schedule[robot] = task
        self.given[robot].append((step, task))
        self._goals[robot] = NO_TASK
        if task != NO_TASK:
            self.known[task].robot = robot
            self._goals[robot] = self.known[task].goal

    def visit(self, cells: Integers, step: int) -> None:
        """Do the errands of robots that are where they were to go, one each."""
        for robot in np.flatnonzero(cells == self._goals).tolist():
            task = self.known[int(self.schedule[robot])]
            task.visited += 1
            self.errands.append(Errand(step, robot, task.number, task.visited))
            if task.is_finished:
                self.finished += 1
                del self.known[task.number]
                self._finish(robot, step)
            else:
                self._goals[robot] = task.goal

    def _finish(self, robot: int, step: int) -> None:
        """Take the finished task from a robot."""
        self.schedule[robot] = self._goals[robot] = NO_TASK

    def wait(self, cells: Integers, step: int) -> None:
        """Let a step pass in which all robots wait for a plan that is late: no errand counts."""

    def reveal(self, step: int) -> None:
        """Reveal tasks until as many are known as the problem says."""
        while len(self.known) < self._revealed:
            self._add(self._source[len(self.tasks) % len(self._source)], step)

    def _add(self, cells: tuple[int, ...], step: int) -> LeagueTask:
        task = LeagueTask(len(self.tasks), cells, step)
        self.tasks.append(task)
        self.known[task.number] = task
        return task


class TaskQueues(TaskPool):
    """Tasks of 2023, which a strategy gives to robots; each robot has a queue.

    Schedules have no effect. Errands count while robots wait for a late plan too.
    """

    def __init__(self, problem: League) -> None:
        robots = len(problem.starts)
        every, number = len(problem.tasks), len(problem.starts)
        self._queues: list[list[int]] = [[] for _ in range(robots)]
        in_file = iter(range(every))
        self._next: list[Iterator[int]] = [
            in_file
            if problem.strategy == GREEDY
            else iter(range(robot, every, number))
            if problem.strategy == FIXED
            else (place % every for place in count(robot, number))
            for robot in range(robots)
        ]
        self._length = problem.revealed // robots
        super().__init__(problem)

    def propose(self, schedule: Integers, step: int) -> None:
        """Do nothing: the strategy gives tasks to robots."""

    def _finish(self, robot: int, step: int) -> None:
        self._queues[robot].pop(0)
        super()._finish(robot, step)

    def wait(self, cells: Integers, step: int) -> None:
        """Do the errands of robots that wait where they were to go."""
        self.visit(cells, step)
        self.reveal(step)

    def reveal(self, step: int) -> None:
        """Fill the queues of robots, in order of their numbers."""
        for robot in np.flatnonzero(self.schedule == NO_TASK).tolist():
            queue = self._queues[robot]
            while len(queue) < self._length:
                place = next(self._next[robot], NO_TASK)
                if place == NO_TASK:
                    break
                queue.append(self._add(self._source[place], step).number)
            if queue:
                self._give(robot, queue[0], step)


def tasks_of(problem: League) -> TaskPool:
    """Return the tasks of a problem before its first step."""
    return TaskQueues(problem) if problem.strategy else TaskPool(problem)
