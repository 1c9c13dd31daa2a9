"""The command ``warehouse plan``, which runs planners on one problem with several robots."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from agents.errors import PlanError
from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.planners.runs import (
    AUTO,
    KIVA,
    SCENARIO,
    SOLVERS,
    FloorOption,
    find_floor,
    make_solver,
    random_problem,
    scenario_problem,
    solve_checked,
)
from agents.lab.console import options
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.output import Film
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say, warnings_printed
from agents.lab.parameters import Whole, one_of
from agents.mapf.graph import Graph
from agents.mapf.problem import Plan, Problem
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.files.tables import write_table
from warehouse_core.motion.backends import load_backend
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Pose, Track, middle
from warehouse_core.wording import counted, listed, seconds_of
from warehouse_core.world.moves import COMPASS, HEADINGS, MOVES
from warehouse_core.world.tables import Integers

ROBOTS = 32
PATHS = ".csv"

PLANNER = f"{options.PLANNER} Arguments may follow, as in pibt:turn_cost=1. May be repeated."
ONCE = listed(list(SOLVERS))
SHOWN_PATHS = 3
"""Number of robots whose paths are shown; they are the last ones to arrive."""

ANGLES = (-math.pi / 2, 0.0, math.pi / 2, math.pi)
"""Angles of robots that head north, east, south and west, in radians."""

CHOICE = "--planner auto chose lacam: it proves plans of small teams optimal, and improves others."


def plan(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="A MovingAI scenario file (.scen). Without it, starts and goals on --layout are "
            "random.",
            show_default=False,
        ),
    ] = None,
    layout: FloorOption = None,
    robots: Annotated[
        int | None,
        option(
            "--robots -r N",
            f"{options.ROBOTS} Default: all in FILE, or {ROBOTS} without it.",
            Whole(1, MAX_BODIES),
        ),
    ] = None,
    moves: Annotated[
        str,
        option(
            "--moves NAME",
            f"{options.MOVES} turn needs a planner that knows headings: auto, lacam, "
            "circulation or windowed. All robots head east at first.",
            one_of(*MOVES),
        ),
    ] = COMPASS,
    seed: options.Seed = 0,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    drive: Annotated[
        bool,
        option(
            "--drive",
            "Also let rigid bodies execute the plans, once in joint steps and once driving through "
            "cells.",
        ),
    ] = False,
    *,
    planner: Annotated[
        list[str],
        option(
            "--planner NAME",
            f"{PLANNER} Also {ONCE}, or file.py:function. Plans of ecbs:w=1.2 cost at most 1.2 "
            "times the optimum. Default: auto.",
            **MANY,
        ),
    ],
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} The paths of one planner as a table (.csv) or a replay (.html, .gif, "
            ".mp4, .svg, .png). May be repeated.",
            callback=writable(PATHS, replays=True),
            **MANY,
        ),
    ],
) -> None:
    """Plan paths for several robots.

    Prints makespan, sum of costs and planning time of each planner, next to a
    bound. For robots that get one goal after another, and for many scenarios,
    use: warehouse compare planners.

    Example: warehouse plan --robots 64 --planner lacam --planner pibt --seed 1
    """
    if drive:
        load_backend("driving")  # so that a missing package is an error before planning
    if save and len(planner) > 1:
        raise typer.BadParameter("--save takes the paths of one planner; name it with --planner")
    if file is None:
        title = f"layout {layout or KIVA}, seed {seed}"
        problem = random_problem(find_floor(layout), robots or ROBOTS, seed, moves)
    else:
        check_file(file)
        title, problem = str(file), scenario_problem(file, layout, robots, moves)
    names = planner or [AUTO]
    with warnings_printed():
        solvers = [make_solver(name, seed, problem, plan_seconds) for name in names]
    if AUTO in names:
        say(CHOICE)
    total, longest = problem.lower_bound, max(problem.fewest_steps.tolist(), default=0)
    rows, executed, notes = list[tuple[str, ...]](), list[tuple[str, ...]](), list[str]()
    rows.append(("lower bound", str(longest), str(total), "1.000", "", ""))
    for name, solve in zip(names, solvers, strict=True):
        begin = time.perf_counter()
        try:
            found, seconds, _ = solve_checked(name, solve, problem, plan_seconds)
        except PlanError as error:
            notes.append(f"{name}: {error}")
            rows.append((name, *["none"] * 3, "", f"{time.perf_counter() - begin:.3f}"))
            continue
        rows.append((name, *measures_of(found, total), f"{seconds:.3f}"))
        executed += execute(name, problem, found) if drive else ()
        for path in save:
            save_plan(path, problem, found, name)
    header = "planner", "makespan", "sum of costs", "times the bound", "proved bound", "seconds"
    caption = (
        "lower bound: the longest of the shortest paths, and their sum; "
        "proved bound: no plan has a lower sum of costs"
    )
    print_table(TextTable(header, rows, f"{counted(problem.robots, 'robot')}, {title}", caption))
    if executed:
        columns = "planner", "on bodies", "seconds", "joules", "hits"
        caption = "until all robots are at rest; a hit between two robots counts for both"
        print_table(TextTable(columns, executed, caption=caption))
    for note in notes:
        print_error(note)
    if len(notes) == len(names):
        raise typer.Exit(1)


def check_file(file: Path) -> None:
    """Raise ``typer.BadParameter`` if the problem file is missing or has another format."""
    if not file.exists():
        raise typer.BadParameter(f"{file}: there is no such file or folder")
    if file.is_dir():
        raise typer.BadParameter(
            f"{file}: a folder has several problems; use: warehouse compare planners {file}"
        )
    if file.suffix.lower() != SCENARIO:
        raise typer.BadParameter(f"{file}: unknown format of a problem; allowed: {SCENARIO}")


def measures_of(found: Plan, bound: int) -> tuple[str, ...]:
    """Return makespan, sum of costs, ratio of costs to a bound, and proved bound, as text."""
    cost = found.sum_of_costs
    ratio = cost / bound if bound else 1.0
    proved = "" if found.bound is None else str(found.bound)
    return str(found.makespan), str(cost), f"{ratio:.3f}", proved


def execute(name: str, problem: Problem, found: Plan) -> Iterator[tuple[str, ...]]:
    """Let bodies execute a plan in each of ``EXECUTIONS``, and yield a table row for each."""
    from agents.mapf.execution import EXECUTIONS  # here, because it loads pymunk

    for mode, run in EXECUTIONS.items():
        took = run(problem.graph.layout, found.cells)
        yield name, mode, seconds_of(took.seconds), f"{took.joules:,.0f}", str(took.hits)


def save_plan(path: Path, problem: Problem, found: Plan, name: str) -> None:
    """Write the paths of a plan as a table, or as a replay."""
    if path.suffix.lower() != PATHS:
        title = f"{name}, {counted(problem.robots, 'robot')}"
        track = track_of_plan(problem.graph, found.cells, title, found.headings)
        Film(partial(list, [track])).save(path)
        return
    headings = np.zeros_like(found.cells) if found.headings is None else found.headings
    letters = [""] if found.headings is None else HEADINGS
    lines = (
        [step, robot, *problem.graph.layout.cell(cell), letters[heading]]
        for step, (cells, heads) in enumerate(zip(found.cells.tolist(), headings, strict=True))
        for robot, (cell, heading) in enumerate(zip(cells, heads.tolist(), strict=True))
    )
    write_table(path, ["step", "robot", "row", "col", "heading"], lines)
    say(f"saved {path}")


def track_of_plan(
    graph: Graph, cells: Integers, title: str, facing: Integers | None = None
) -> Track:
    """Return the track of a plan, with the paths of the last robots to arrive.

    Args:
        graph: graph of the layout.
        cells: cell of each robot after each step, ``[T + 1, R]``.
        title: title of the track.
        facing: heading of each robot after each step, ``[T + 1, R]``. By default robots head in
            the direction of their last move.
    """
    layout, robots = graph.layout, cells.shape[1]
    is_there = np.logical_and.accumulate((cells == cells[-1])[::-1])[::-1]
    last = np.argsort(is_there.sum(axis=0), kind="stable")[:SHOWN_PATHS].tolist()
    paths = {robot: layout.cells(cells[:, robot]) for robot in last}
    headings: list[float | None] = [None] * robots
    items, battery = (None,) * robots, (1.0,) * robots
    frames = []
    for step, row in enumerate(cells):
        if facing is not None:
            headings = [ANGLES[heading] for heading in facing[step].tolist()]
        elif step:
            moves = (graph.neighbours[cells[step - 1]] == row[:, None]).argmax(axis=1).tolist()
            headings = [
                ANGLES[move] if move < len(ANGLES) else before
                for move, before in zip(moves, headings, strict=True)
            ]
        poses = tuple(
            Pose(middle(cell), heading, loaded=False)
            for cell, heading in zip(layout.cells(row), headings, strict=True)
        )
        plans = StepPlans({robot: path[step:] for robot, path in paths.items()})
        arrived = f"{is_there[step].sum()} of {counted(robots, 'robot')} in their final cells"
        fleet = FleetFrame((), items, battery, plans)
        frames.append(
            Frame(layout.rows, poses, float(step), arrived, clock=float(step), fleet=fleet)
        )
    return Track(frames, {}, title=title)
