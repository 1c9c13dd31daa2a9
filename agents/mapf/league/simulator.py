"""Plays a problem of the League: an entry plans, robots move, tasks are finished.

An entry that takes longer than a step lets steps pass in which all robots wait, and its plan is
carried out when it is there. A joint action with an error is replaced by waiting. ``R`` is the
number of robots.

Source: ``src/CompetitionSystem.cpp`` of the League's Start-Kit, 1.1.5 and 2.1.2.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import EAST, Graph
from agents.mapf.league.entry import Entry, View
from agents.mapf.league.log import Log
from agents.mapf.league.result import Result
from agents.mapf.league.rules import LOST, WAITING, action_error, result_of
from agents.mapf.league.tasks import tasks_of
from warehouse_core.world.robot_runners import League
from warehouse_core.world.tables import Integers

Clock = Callable[[], float]


def play(
    problem: League,
    entry: Entry,
    steps: int,
    seconds: float,
    clock: Clock = time.perf_counter,
) -> Result:
    """Return what an entry reaches in so many steps.

    Args:
        problem: problem of 2023 or 2024.
        entry: scheduler and planner.
        steps: number of steps.
        seconds: time for each step.
        clock: clock that measures the entry.

    Raises:
        PlanError: no way leads to a robot or a task from the first robot.
    """
    if problem.year == 2026:
        raise PlanError("problems of 2026, whose actions take several ticks, are not played")
    graph, tasks = Graph(problem.layout), tasks_of(problem)
    check_reachable(graph, problem)
    cells: Integers = problem.layout.numbers(problem.starts)
    log = Log(cells)
    headings: Integers = np.full(len(cells), EAST)
    passed = [list[int]() for _ in cells]
    while log.steps < steps:
        view = View(log.steps, cells, headings, tasks.known, tasks.schedule, passed)
        start = clock()
        schedule, plan = entry.plan(view, 1)
        log.seconds.append(clock() - start)
        for _ in range(min(int(log.seconds[-1] // seconds), steps - log.steps)):
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
    return log.result(problem, tasks)


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
