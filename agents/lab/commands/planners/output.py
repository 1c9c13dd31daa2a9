"""Results in the output format of the League of Robot Runners, of version ``2024 LoRR``.

The action model of robots without headings is ``MAPF``, as PlanViz calls it, whose moves are ``U``
to the row below, ``D`` to the row above, ``L`` and ``R``; ``W`` is waiting. With headings it is
``MAPF_T``, the League's own: ``F`` forward, ``R`` and ``C`` turn clockwise and back, ``W`` waits.

Source: ``Input_Output_Format.md`` of the League's Start-Kit, version 2.1; for ``MAPF`` the script
``util.py`` of PlanViz.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.lab.commands.planners.runs import Errand
from agents.mapf.graph import Graph
from agents.mapf.lifelong import LifelongRun
from agents.mapf.problem import Plan
from warehouse_core.files.atomic import atomic_path
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

MOVES = np.array(list("DRULW"))
"""The letters of N, E, S, W and waiting."""

TURNS = np.array(list("WR?C"))
"""The letters of quarters clockwise by which a robot turns in its cell."""

TIMEOUT = "the planner took too long; all robots waited"


class Record(NamedTuple):
    """The course of tasks, from their release to their end.

    Attributes:
        tasks: step at which each task was released, and its cells.
        given: ``[R]`` lists of pairs: the step at which a robot got a task, and the task's number.
        errands: visits to cells of tasks.
        finished: number of finished tasks.
    """

    tasks: Sequence[tuple[int, Sequence[int]]]
    given: Sequence[Sequence[tuple[int, int]]]
    errands: Sequence[Errand]
    finished: int


def record_of_plan(plan: Plan) -> Record:
    """Return a record in which the goal of each robot is a task."""
    goals, costs = plan.cells[-1].tolist(), plan.costs.tolist()
    errands = [Errand(cost, robot, robot, 1) for robot, cost in enumerate(costs)]
    return Record(
        [(0, [goal]) for goal in goals],
        [[(0, robot)] for robot in range(len(goals))],
        sorted(errands),
        len(goals),
    )


def record_of_run(run: LifelongRun) -> Record:
    """Return a record in which each goal of each robot is a task."""
    tasks, errands = [(0, [goal]) for goal in run.goals[0].tolist()], list[Errand]()
    given = [[(0, robot)] for robot in range(len(tasks))]
    for step, robot in np.argwhere(run.cells[1:] == run.goals[:-1]).tolist():
        errands.append(Errand(step + 1, robot, given[robot][-1][1], 1))
        given[robot].append((step + 1, len(tasks)))
        tasks.append((step + 1, [int(run.goals[step + 1, robot])]))
    return Record(tasks, given, errands, len(errands))


def write_result(
    path: Path,
    graph: Graph,
    cells: Integers,
    record: Record,
    sum_of_costs: int,
    seconds: Sequence[float],
    lost: Sequence[int] = (),
    *,
    headings: Integers | None = None,
) -> None:
    """Write a result, whole or not at all.

    Args:
        path: path of the file.
        graph: graph of the floor.
        cells: ``[T + 1, R]``, the cells of the robots.
        record: record of their tasks.
        sum_of_costs: sum of the costs of the robots.
        seconds: time of each call of the planner.
        lost: steps that took too long, from 0.
        headings: ``[T + 1, R]``, headings of the robots, if they have any.
    """
    robots = cells.shape[1]
    if headings is None:
        first = ["N/A"] * robots
        letters = MOVES[(graph.neighbours[cells[:-1]] == cells[1:, :, None]).argmax(axis=2)]
    else:
        first = [HEADINGS[heading] for heading in headings[0]]
        turns = TURNS[(headings[1:] - headings[:-1]) % len(HEADINGS)]
        letters = np.where(cells[1:] == cells[:-1], turns, "F")
    paths = [",".join(column) for column in letters.T]
    schedule = [",".join(f"{step}:{task}" for step, task in each) for each in record.given]
    result: dict[str, Any] = {
        "actionModel": "MAPF" if headings is None else "MAPF_T",
        "version": "2024 LoRR",
        "AllValid": "Yes",
        "teamSize": robots,
        "start": [
            [*cell, letter]
            for cell, letter in zip(graph.layout.cells(cells[0]), first, strict=True)
        ],
        "numTaskFinished": record.finished,
        "sumOfCost": sum_of_costs,
        "makespan": len(cells) - 1,
        "numPlannerErrors": 0,
        "numScheduleErrors": 0,
        "numEntryTimeouts": len(lost),
        "actualPaths": paths,
        "plannerPaths": paths,
        "plannerTimes": list(map(float, seconds)),
        "errors": [[-1, -1, -1, step, TIMEOUT] for step in lost],
        "actualSchedule": schedule,
        "plannerSchedule": schedule,
        "scheduleErrors": [],
        "events": [list(errand) for errand in record.errands],
        "tasks": [
            [number, step, graph.layout.places(np.array(places)).ravel().tolist()]
            for number, (step, places) in enumerate(record.tasks)
        ],
    }
    with atomic_path(path) as part:
        part.write_text(json.dumps(result), encoding="utf-8")
