"""An entry to the League: a scheduler says who does which task, a planner who goes where.

``R`` is the number of robots.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from agents.mapf.graph import Graph
from agents.mapf.league.rules import WAITING, result_of
from agents.mapf.league.scheduler import Scheduler, is_full, most_busy
from agents.mapf.league.tasks import NO_TASK, LeagueTask
from agents.mapf.planner import NO_CELLS, HeadedPlanner, Situation, check_turns
from warehouse_core.world.moves import FORWARD, HEADINGS, LEFT, RIGHT
from warehouse_core.world.tables import Integers

__all__ = ["Entry", "PlannedEntry", "View"]


class View(NamedTuple):
    """What an entry knows when it is asked for a plan.

    Attributes:
        step: number of steps, or ticks, so far.
        cells, headings: ``[R]`` each, of the robots once staged actions are carried out.
        known: tasks that are known and not finished, by number.
        schedule: ``[R]``, the task of each robot, or ``NO_TASK``.
        passed: ``[R]`` lists of the cells that staged actions lead each robot through, in turn.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.league.entry import View
        >>> from agents.mapf.league.tasks import LeagueTask
        >>> known, schedule = {7: LeagueTask(7, (1, 3), revealed=0)}, np.array([7])
        >>> view = View(0, np.array([0]), np.array([1]), known, schedule, passed=[[]])
        >>> view.known[int(view.schedule[0])].goal
        1
    """

    step: int
    cells: Integers
    headings: Integers
    known: Mapping[int, LeagueTask]
    schedule: Integers
    passed: list[list[int]]


class Entry(Protocol):
    """Answers a view with a schedule, ``[R]`` tasks, and ``[R, steps]`` actions.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.league.entry import Entry
        >>> class Waiting:
        ...     def plan(self, view, steps):
        ...         return view.schedule, np.full((len(view.cells), steps), 3)
        >>> entry: Entry = Waiting()
    """

    def plan(self, view: View, steps: int) -> tuple[Integers, Integers]:
        """Return a schedule and the actions of so many steps."""


class PlannedEntry:
    """A scheduler and a planner of this project.

    Args:
        graph: floor.
        planner: planner of the floor.
        scheduler: scheduler, or ``None`` if tasks are given to robots, as in 2023.

    Example:
        >>> from agents.mapf.epibt import EPIBT
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.league.entry import PlannedEntry
        >>> from agents.mapf.league.scheduler import Scheduler
        >>> from warehouse_core import shelf_layout
        >>> graph = Graph(shelf_layout())
        >>> entry = PlannedEntry(graph, EPIBT(graph), Scheduler(graph, tasks=12))
    """

    def __init__(self, graph: Graph, planner: HeadedPlanner, scheduler: Scheduler | None) -> None:
        self._graph, self._planner, self._scheduler = graph, planner, scheduler
        planner.reset()

    def plan(self, view: View, steps: int) -> tuple[Integers, Integers]:
        """Return a schedule and the actions of so many steps; see ``Entry``."""
        if self._scheduler is None:
            (ahead, wanted), schedule = foreseen(view), view.schedule
        else:
            ahead, wanted, schedule = assigned(view, self._scheduler)
        errands = errands_of(ahead, wanted)
        return schedule, plan_steps(
            self._graph, self._planner, view.cells, view.headings, errands, steps
        )


def assigned(view: View, scheduler: Scheduler) -> tuple[dict[int, LeagueTask], Integers, Integers]:
    """Return the tasks of robots once they have done what is staged.

    Returns:
        Tasks that are known then, the task of each robot then, and the schedule to propose now, in
        which a robot that has not quite finished its task keeps it.
    """
    known, schedule = foreseen(view)
    wanted = scheduler.assign(view.cells, view.headings, known, schedule)
    return known, wanted, np.where(schedule == view.schedule, wanted, view.schedule)


def errands_of(known: Mapping[int, LeagueTask], schedule: Integers) -> list[list[int]]:
    """Return the cells that each robot is still to visit for its task, in turn."""
    return [
        [] if task == NO_TASK else list(known[task].cells[known[task].visited :])
        for task in schedule.tolist()
    ]


def foreseen(view: View) -> tuple[dict[int, LeagueTask], Integers]:
    """Return known tasks and schedule as they are once robots have done what is staged."""
    known, schedule = dict(view.known), view.schedule.copy()
    for robot, way in enumerate(view.passed):
        number = int(schedule[robot])
        if number == NO_TASK or not way:
            continue
        task = replace(known[number])
        for cell in way:
            task.visited += not task.is_finished and cell == task.goal
        known[number] = task
        if task.is_finished:
            schedule[robot] = NO_TASK
            del known[number]
    return known, schedule


def first_robots(graph: Graph, cells: Integers, errands: list[list[int]]) -> Integers:
    """Return which robots go first on a full floor: those that have least left to do.

    What is left is the sum of Manhattan distances from cell to cell.
    """
    open_cells = len(graph.layout.open_cells)
    if not is_full(open_cells, len(cells)):
        return NO_CELLS
    ways = [[cell, *each] for cell, each in zip(cells.tolist(), errands, strict=True)]
    legs = [np.diff(graph.layout.places(np.array(way)), axis=0) for way in ways]
    left = np.array([np.abs(each).sum() for each in legs])
    busy = np.flatnonzero([bool(each) for each in errands])
    return busy[np.argsort(left[busy], kind="stable")[: most_busy(open_cells, len(cells))]]


def plan_steps(
    graph: Graph,
    planner: HeadedPlanner,
    cells: Integers,
    headings: Integers,
    errands: list[list[int]],
    steps: int,
) -> Integers:
    """Return the actions of robots through some steps, ``[R, steps]``, by a planner.

    Args:
        graph: floor.
        planner: planner of the floor.
        cells: ``[R]``, cells of the robots.
        headings: ``[R]``, their headings.
        errands: cells that each robot is to visit in turn; one that has none gives way. On a full
            floor the robots of ``first_robots`` go first.
        steps: number of steps.
    """
    actions = np.full((len(cells), steps), WAITING)
    nobody, done = np.zeros(len(cells), np.bool_), [0] * len(cells)
    goals = np.array([(each or [cell])[0] for each, cell in zip(errands, cells, strict=True)])
    urgent = first_robots(graph, cells, errands)
    for step in range(steps):
        situation = Situation(cells, goals, nobody, NO_CELLS, urgent)
        places = check_turns(graph, situation, headings, planner.next_places(situation, headings))
        turned, reached = np.divmod(places, graph.size)
        quarters = (turned - headings) % len(HEADINGS)
        turns = np.select([quarters == 1, quarters == 3], [RIGHT, LEFT], WAITING)
        actions[:, step] = np.where(reached != cells, FORWARD, turns)
        cells, headings = result_of(graph, cells, headings, actions[:, step])
        for robot in np.flatnonzero(cells == goals).tolist() if step + 1 < steps else ():
            done[robot] += 1
            left = errands[robot][done[robot] :]
            goals[robot] = left[0] if left else cells[robot]
    return actions
