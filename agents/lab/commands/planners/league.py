"""The command ``warehouse league``: problems of the League of Robot Runners, by its rules."""

from __future__ import annotations

import os
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from agents.errors import PlanError
from agents.lab.commands.planners.replay import track_of_plan
from agents.lab.console import options
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.output import Film
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, warnings_printed
from agents.lab.parameters import MAX_VALUE, Number
from agents.mapf.graph import Graph
from agents.mapf.league.checker import cells_of, check_result
from agents.mapf.league.entry import PlannedEntry
from agents.mapf.league.result import Result, read_result, write_result
from agents.mapf.league.scheduler import CROWD, Scheduler
from agents.mapf.league.simulator import planned_steps, play
from agents.mapf.league.usual import SHARE, usual_planner
from agents.mapf.planner import GraphPlanner, HeadedPlanner
from agents.registry import make_planner
from warehouse_core import Layout
from warehouse_core.wording import counted
from warehouse_core.world.robot_runners import League, load_league

STEPS, SECONDS = 1000, 1.0

SUFFIX = ".json"

BESIDE = "A result .json of the League to check and to show beside."
StepSeconds = Annotated[
    float,
    option(
        "--step-seconds S",
        "Seconds of a step, or of ten ticks of 2026; all robots wait in each step in which their "
        "plan is late.",
        Number(0.001, MAX_VALUE),
    ),
]


def league(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE", help="Problems of the League of Robot Runners, .json."),
    ],
    planner: Annotated[
        list[str] | None,
        option(
            "--planner NAME",
            f"{options.PLANNER} It must know headings; arguments may follow, as in epibt:tries=10; "
            "may be repeated. Default: windowed, or in crowds windowed-directed or "
            f"circulation-directed, which take at most {SHARE:.0%} of each step, or epibt-aisles "
            f"for more than {CROWD:,} robots.",
            show_default=False,
        ),
    ] = None,
    beside: Annotated[
        list[Path] | None,
        option(
            "--beside FILE",
            f"{BESIDE} May be repeated, one for each problem, in their order.",
            show_default=False,
        ),
    ] = None,
    max_steps: Annotated[
        int | None,
        options.parameter_option("max_steps", more=f"Default: those of --beside, or {STEPS}."),
    ] = None,
    step_seconds: StepSeconds = SECONDS,
    seed: options.Seed = 0,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} The result of one problem and planner as .json, which PlanViz reads, "
            "or as a replay: .html, .gif, .mp4, .svg, .png; may be repeated.",
            callback=writable(SUFFIX, replays=True),
            **MANY,
        ),
    ],
) -> None:
    """Play the League of Robot Runners.

    Robots drive forward, turn and wait. A scheduler gives them tasks, of
    which all cells are to be visited in turn; of 2023, the problem does.
    Prints how many tasks are finished, and checks it by the rules.

    Example: warehouse league RANDOM-01.json --beside MR24-RANDOM-01.json
    """
    planners = planner or []
    if len(beside or ()) not in (0, len(files)):
        raise typer.BadParameter(
            f"--beside is given {len(beside or ())} times for {counted(len(files), 'problem')}"
        )
    if save and len(files) * max(len(planners), 1) != 1:
        raise typer.BadParameter("--save takes the result of one problem and one planner")
    for name in planners:  # what is wrong with one is told before files; a cell needs no trials
        headed_planner(name, seed, Layout(["."]), 1)
    rows = []
    for file, other in zip_longest(files, beside or ()):
        with warnings_printed():
            problem = load_league(file)
        theirs = None if other is None else read_result(other, problem.layout)
        steps = max_steps or (len(theirs.actual) if theirs else STEPS)
        for name in planners or [usual_name(problem, step_seconds)]:
            ours = play_checked(problem, name, steps, step_seconds, seed)
            rows.append(row_of(file.stem, name, ours, theirs))
            for path in save:
                save_result(path, ours, problem, f"{name}, {file.stem}")
        if theirs and other:
            verdict = check_result(problem, theirs)
            if verdict.error:
                print_error(f"{other}: {verdict.error}")
            elif verdict.finished is None:
                print_error(
                    f"{other}: it does not say who had which task; its moves keep the rules"
                )
            rows.append(row_of(file.stem, "theirs", theirs, theirs))
    header = (
        "problem", "by", "robots", "steps", "tasks", "share", "late", "errors", "s a step",
        "longest",
    )  # fmt: skip
    cores = counted(os.cpu_count() or 1, "core")
    caption = f"late: steps in which all robots waited for a plan; s a step: median on {cores}"
    if beside:
        caption += " for ours, as in their files for theirs (the League's machine has 32 cores)"
    print_table(TextTable(header, rows, caption=caption))


def usual_name(problem: League, step_seconds: float) -> str:
    """Return the name, with arguments, of the planner of a problem for which none is named."""
    seconds = step_seconds / planned_steps(problem)
    usual = usual_planner(
        len(problem.layout.open_cells), len(problem.starts), seconds,
        is_scheduled=not problem.strategy,
    )  # fmt: skip
    given = (
        f"{key}={value if value is True else format(value, 'g')}"
        for key, value in (usual.floor | usual.others).items()
    )
    return f"{usual.name}:{','.join(given)}"


def play_checked(problem: League, name: str, steps: int, seconds: float, seed: int) -> Result:
    """Return the result of a planner by name, which has been found to keep the rules.

    Raises:
        PlanError: the result breaks a rule.
    """
    result = play(problem, entry_of(problem, name, seed), steps, seconds)
    if error := check_result(problem, result).error:
        raise PlanError(f"planner {name!r} breaks a rule of the League: {error}")
    return result


def entry_of(problem: League, name: str, seed: int) -> PlannedEntry:
    """Return an entry with a planner by name."""
    layout, robots = problem.layout, len(problem.starts)
    planner = headed_planner(name, seed, layout, robots)
    graph = Graph(layout)
    floor = planner.graph if isinstance(planner, GraphPlanner) else graph
    scheduler = None if problem.strategy else Scheduler(floor, problem.revealed)
    return PlannedEntry(graph, planner, scheduler)


def headed_planner(name: str, seed: int, layout: Layout, robots: int) -> HeadedPlanner:
    """Return a planner by name.

    Raises:
        PlanError: the planner knows no headings.
        AgentError: there is no such planner.
    """
    made = make_planner(name, seed, layout, robots)
    if not isinstance(made, HeadedPlanner):
        raise PlanError(f"planner {name!r} plans for robots without headings")
    return made


def row_of(problem: str, name: str, result: Result, theirs: Result | None) -> tuple[str, ...]:
    """Return the row of a result in the table."""
    share = f"{result.finished / theirs.finished:.1%}" if theirs and theirs.finished else ""
    errors = len(result.errors) + len(result.schedule_errors)
    times = (
        [f"{of(result.seconds):.3f}" for of in (np.median, np.max)] if result.seconds else ["", ""]
    )
    steps, robots = result.actual.shape
    counts = robots, steps, result.finished
    return (problem, name, *map(str, counts), share, str(result.late), str(errors), *times)


def save_result(path: Path, result: Result, problem: League, title: str) -> None:
    """Save a result as the League does, or as a replay."""
    if path.suffix.lower() == SUFFIX:
        write_result(path, result, problem.layout)
        return
    track = track_of_plan(Graph(problem.layout), cells_of(problem, result), title)
    Film(partial(list, [track])).save(path)
