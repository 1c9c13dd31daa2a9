"""Plays a problem of the League: an entry plans, robots move, tasks are finished.

In 2023 and 2024 an entry plans one step. If that takes longer than a step, steps pass in which all
robots wait, until the plan is there. In 2026 actions take several ticks, and an entry plans several
actions while robots carry out those before; if that takes too long, they have nothing to do. A
joint action with an error is replaced by waiting. ``R`` is the
number of robots.

Source: ``src/CompetitionSystem.cpp`` of the League's Start-Kit, 1.1.5, 2.1.2 and 3.1.0.
"""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import EAST, Graph
from agents.mapf.league.delays import DelayDraw
from agents.mapf.league.entry import Entry, View
from agents.mapf.league.executor import Executor
from agents.mapf.league.log import Log
from agents.mapf.league.result import Result
from agents.mapf.league.rules import LOST, WAITING, action_error, result_of
from agents.mapf.league.tasks import NO_TASK, TaskPool, tasks_of
from warehouse_core.world.robot_runners import League
from warehouse_core.world.tables import Integers

__all__ = ["play"]

Clock = Callable[[], float]

PERIOD = 10
"""Ticks of 2026 between two plans."""


def play(
    problem: League,
    entry: Entry,
    steps: int,
    seconds: float,
    clock: Clock = time.perf_counter,
) -> Result:
    """Return what an entry reaches in so many steps.

    Args:
        problem: problem of any year.
        entry: scheduler and planner.
        steps: number of steps, of 2026 ticks.
        seconds: time for a plan: a step, or ``PERIOD`` ticks.
        clock: clock that measures the entry.

    Raises:
        PlanError: no way leads to a robot or a task from the first robot.

    Example:
        >>> from agents.mapf.epibt import EPIBT
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.league.entry import PlannedEntry
        >>> from agents.mapf.league.scheduler import Scheduler
        >>> from agents.mapf.league.simulator import play
        >>> from warehouse_core import Layout
        >>> from warehouse_core.world.robot_runners import League
        >>> layout = Layout(["....", "...."])
        >>> problem = League(layout, starts=[(0, 0)], tasks=[((0, 3), (1, 0))], revealed=1)
        >>> graph = Graph(layout)
        >>> entry = PlannedEntry(graph, EPIBT(graph), Scheduler(graph, problem.revealed))
        >>> result = play(problem, entry, steps=20, seconds=10)
        >>> result.finished, result.late
        (1, 0)
    """
    graph = Graph(problem.layout)
    check_reachable(graph, problem)
    asked = Asked(entry, clock)
    if problem.year == 2026:
        return play_ticks(graph, problem, asked, steps, seconds)
    return play_steps(graph, problem, asked, steps, seconds)


class Asked:
    """An entry whose plans are timed.

    Attributes:
        seconds: time of each plan.
    """

    def __init__(self, entry: Entry, clock: Clock) -> None:
        self._entry, self._clock = entry, clock
        self.seconds: list[float] = []

    def plan(self, view: View, steps: int) -> tuple[Integers, Integers]:
        """Return the plan of the entry."""
        start = self._clock()
        answer = self._entry.plan(view, steps)
        self.seconds.append(self._clock() - start)
        return answer


def play_steps(graph: Graph, problem: League, entry: Asked, steps: int, seconds: float) -> Result:
    """Play a problem of 2023 or 2024, whose actions take a step; see ``play``."""
    tasks = tasks_of(problem)
    cells: Integers = problem.layout.numbers(problem.starts)
    log = Log(cells)
    headings: Integers = np.full(len(cells), EAST)
    passed = [list[int]() for _ in cells]
    while log.steps < steps:
        view = View(log.steps, cells, headings, tasks.known, tasks.schedule, passed)
        schedule, plan = entry.plan(view, 1)
        for _ in range(min(int(entry.seconds[-1] // seconds), steps - log.steps)):
            log.late += 1
            log.add(np.full(len(cells), WAITING), np.full(len(cells), LOST))
            tasks.wait(cells, log.steps)
        if log.steps == steps:
            break
        actions = planned = plan[:, 0]
        if error := action_error(graph, cells, headings, actions):
            log.errors.append((*error[:2], log.steps + 1, error.text))
            actions = np.full(len(cells), WAITING)
        cells, headings = result_of(graph, cells, headings, actions)
        log.add(actions, planned if len(planned) == len(cells) else np.full(len(cells), LOST))
        tasks.propose(schedule, log.steps)
        tasks.visit(cells, log.steps)
        tasks.reveal(log.steps)
    return log.result(problem, tasks, entry.seconds)


def play_ticks(graph: Graph, problem: League, entry: Asked, steps: int, seconds: float) -> Result:
    """Play a problem of 2026, whose steps are ticks; see ``play``.

    While an entry plans, robots carry out what is staged; the plan begins where that ends.
    """
    tasks = tasks_of(problem)
    cells: Integers = problem.layout.numbers(problem.starts)
    log, delays = Log(cells), DelayDraw(problem.delays, len(cells))
    executor = Executor(graph, cells, np.full(len(cells), EAST), problem.ticks)
    window = planned_steps(problem)
    while log.steps < steps:  # the first plan is made before the first tick
        view = View(
            log.steps, np.array(executor.ends), np.array(executor.end_headings),
            copy.deepcopy(tasks.known), tasks.schedule.copy(), executor.passed,
        )  # fmt: skip
        schedule, plan = entry.plan(view, window)
        ticks = max(1, math.ceil(entry.seconds[-1] / seconds * PERIOD))
        log.late += min(max(0, ticks - PERIOD), steps - log.steps)
        ticks = max(ticks, PERIOD) if len(entry.seconds) > 1 else max(0, ticks - PERIOD)
        for _ in range(min(ticks, steps - log.steps)):
            tick(log, executor, tasks, delays)
        done = np.isin(schedule, view.schedule[view.schedule != NO_TASK]) & ~np.isin(
            schedule, list(tasks.known)
        )
        tasks.propose(np.where(done, NO_TASK, schedule), log.steps)
        executor.stage(plan)
    return log.result(problem, tasks, entry.seconds, delays.intervals)


def planned_steps(problem: League) -> int:
    """Return the number of steps of each plan: those that robots can carry out until the next."""
    return PERIOD // problem.ticks + 1 if problem.year == 2026 else 1


def tick(log: Log, executor: Executor, tasks: TaskPool, delays: DelayDraw) -> None:
    """Let a tick of 2026 pass."""
    actions = executor.tick(delays.next_tick())
    log.add(actions, actions)
    tasks.visit(np.array(executor.cells), log.steps)
    tasks.reveal(log.steps)


def check_reachable(graph: Graph, problem: League) -> None:
    """Raise ``PlanError`` if no way leads to a robot or a task from the first robot."""
    numbers, first = problem.layout.numbers, problem.starts[0]
    robots = [(cell,) for cell in problem.starts]
    for what, all_cells in (("robot", robots), ("task", problem.tasks)):
        for number, cells in enumerate(all_cells):
            parts = graph.parts[numbers([first, *cells])]
            for cell in np.flatnonzero(parts != parts[0])[:1]:
                raise PlanError(
                    f"{what} {number} has {cells[cell - 1]}, to which no way leads from robot 0 "
                    f"in {first}"
                )
