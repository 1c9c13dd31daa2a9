"""The command ``warehouse mapf``: planners on one problem of several robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from agents.errors import PlanError
from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.planners.floors import (
    KIVA,
    FloorOption,
    find_floor,
    random_problem,
    scenario_problem,
    with_moves,
)
from agents.lab.commands.planners.output import record_of_plan, record_of_run, write_result
from agents.lab.commands.planners.replay import track_of_plan
from agents.lab.commands.planners.runs import (
    BOUND,
    HEADED_SOLVERS,
    SOLVERS,
    STEPPERS,
    Unhindered,
    make_solver,
    make_stepper,
    solve_checked,
)
from agents.lab.commands.planners.study import SCENARIO, VALUES, find_scenarios, study
from agents.lab.console import options
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.output import Film
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error
from agents.lab.console.values import parse_sizes
from agents.lab.parameters import Whole, one_of
from agents.mapf.graph import Graph
from agents.mapf.lifelong import LifelongRun, run_lifelong
from agents.mapf.planner import Planner
from agents.mapf.problem import Problem
from agents.registry import PLANNERS
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.motion.backends import load_backend
from warehouse_core.wording import counted, listed, seconds_of
from warehouse_core.world.moves import COMPASS, MOVES, TURN
from warehouse_core.world.tables import Integers

ROBOTS = 32
RESULT = ".json"


PLANNER = f"{options.PLANNER} Arguments may follow, as in pibt:turn_cost=1; may be repeated."
ONCE = listed([name for name in SOLVERS if name not in PLANNERS])

KNOW_HEADINGS = ", ".join(HEADED_SOLVERS)

LIFELONG = "Steps in which a robot that reaches its goal gets another."


def mapf(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FILE",
            help="A MovingAI scenario .scen, several or folders of them. Without it starts and "
            "goals are drawn on --layout.",
            show_default=False,
        ),
    ] = None,
    planner: Annotated[
        list[str] | None,
        option(
            "--planner NAME",
            f"{PLANNER} Where each robot has one goal, also {ONCE}, or file.py:function; "
            "ecbs:w=1.2 costs at most 1.2 times the optimum.",
            show_default=False,
        ),
    ] = None,
    layout: FloorOption = None,
    robots: Annotated[
        str | None,
        option(
            "--robots -r N,N",
            f"{options.ROBOTS} Several, separated by commas, for scenarios. Default: all of the "
            f"file, or {ROBOTS}; of several files 10, 20, 40 and so on.",
            show_default=False,
        ),
    ] = None,
    steps: Annotated[
        int | None,
        option(
            "--lifelong N",
            f"{LIFELONG} Default: each robot has one goal.",
            Whole(1),
        ),
    ] = None,
    moves: Annotated[
        str,
        option(
            "--moves NAME",
            f"{options.MOVES} turn needs a planner that knows headings: {KNOW_HEADINGS}, "
            "circulation or windowed. All robots head east at first.",
            one_of(*MOVES),
        ),
    ] = COMPASS,
    seed: options.Seed = 0,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    drive: Annotated[
        bool,
        option(
            "--drive", "Also let rigid bodies execute the plans, in joint steps and driven through."
        ),
    ] = False,
    jobs: options.Jobs = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} The paths of one planner as .json, in the output format of the League "
            "of Robot Runners, or as a replay: .html, .gif, .mp4, .svg, .png. Of several files "
            "each plan as .csv, and curves as .svg or .png; may be repeated.",
            callback=writable(RESULT, VALUES, replays=True),
            **MANY,
        ),
    ],
) -> None:
    """Run planners on a problem of robots.

    Prints makespan, sum of costs and time of plans, or the goals or tasks
    that a lifelong run reaches in a step, each beside a bound. For several
    scenarios or numbers of robots it prints how many are solved.

    Example: warehouse mapf --robots 64 --planner lacam --planner pibt --seed 1
    """
    sizes = parse_sizes(robots) if robots is not None else []
    if sizes and sizes[-1] > MAX_BODIES:
        raise typer.BadParameter(f"--robots has {sizes[-1]}; allowed: 1..{MAX_BODIES}")
    if len(files or ()) > 1 or len(sizes) > 1 or any(path.is_dir() for path in files or ()):
        check_study(files, steps, drive=drive)
        chosen = find_scenarios(files or [])
        study(chosen, planner or ["lacam"], sizes, layout, moves, seed, plan_seconds, jobs, save)
        return
    file, count = next(iter(files or ()), None), next(iter(sizes), None)
    check_file(file, steps)
    if steps is not None and moves == TURN:
        raise typer.BadParameter("--moves turn does not go with --lifelong")
    if drive:
        load_backend("driving")  # what it needs is missed here, and not after the plans
    for path in save:
        if path.suffix.lower() == VALUES:
            raise typer.BadParameter(f"{path}: one plan is saved as .json or as a replay")
    if save and len(planner or ()) != 1:
        raise typer.BadParameter("--save takes the paths of one planner; name one by --planner")
    trials = Trials(seed, plan_seconds, save, drive)
    if file is not None:
        problem = with_moves(scenario_problem(file, layout, count), moves)
        solve_all(problem, planner, trials, str(file))
        return
    name, floor, count = layout or KIVA, find_floor(layout), count or ROBOTS
    if steps is None:
        title = f"layout {name}, seed {seed}"
        problem = with_moves(random_problem(floor, count, seed), moves)
        solve_all(problem, planner, trials, title)
        return
    graph = Graph(floor.layout)

    def start(planner: Planner) -> LifelongRun:
        return run_lifelong(graph, planner, count, steps, seed, floor.starts, floor.goals)

    title = f"{counted(count, 'robot')}, {counted(steps, 'step')}, layout {name}, seed {seed}"
    run_all(graph, planner, trials, start, title)


def check_study(files: Sequence[Path] | None, steps: int | None, *, drive: bool) -> None:
    """Raise if an option does not go with several scenarios or numbers of robots."""
    if not files:
        raise typer.BadParameter(
            "several numbers of --robots need scenarios; see also: warehouse compare planners"
        )
    for name, given in (("--lifelong", steps is not None), ("--drive", drive)):
        if given:
            raise typer.BadParameter(f"{name} goes with one problem, and not with several")


def check_file(file: Path | None, steps: int | None) -> None:
    """Raise if the file of the problem is missing or another, or does not go with an option."""
    if file is None:
        return
    if not file.exists():
        raise typer.BadParameter(f"{file}: there is no such file or folder")
    if file.suffix.lower() != SCENARIO:
        raise typer.BadParameter(f"{file}: unknown format of a problem; allowed: {SCENARIO}")
    if steps is not None:
        raise typer.BadParameter(
            "--lifelong does not go with a .scen: it has one goal for each robot"
        )


@dataclass
class Trials:
    """Planners on one problem: the options of all kinds of problems, and the rows to print."""

    seed: int
    seconds: float
    outputs: Sequence[Path]
    drive: bool
    rows: list[tuple[str, ...]] = field(default_factory=list)
    executed: list[tuple[str, ...]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(
        self, name: str, measures: Sequence[str], graph: Graph, cells: Integers, *result: Any,
        headings: Integers | None = None,
    ) -> None:  # fmt: skip
        """Add what a planner has reached, drive its paths and write them, if that is wanted.

        The further arguments of ``write_result`` come last.
        """
        self.rows.append((name, *measures))
        if self.drive:
            from agents.mapf.execution import EXECUTIONS  # here, because it loads pymunk

            for way, run in EXECUTIONS.items():
                took = run(graph.layout, cells)
                numbers = seconds_of(took.seconds), f"{took.joules:,.0f}", str(took.hits)
                self.executed.append((name, way, *numbers))
        for path in self.outputs:
            if path.suffix.lower() == RESULT:
                write_result(path, graph, cells, *result, headings=headings)
            else:
                title = f"{name}, {counted(cells.shape[1], 'robot')}"
                track = track_of_plan(graph, cells, title, headings)
                Film(partial(list, [track])).save(path)

    def show(self, header: tuple[str, ...], title: str, caption: str) -> None:
        """Print the table, what plans take on bodies if they were driven, and the notes."""
        print_table(TextTable(header, self.rows, title, caption))
        if self.executed:
            header = ("planner", "on bodies", "seconds", "joules", "hits")
            caption = "until all robots are at rest; a hit of two robots counts for both"
            print_table(TextTable(header, self.executed, caption=caption))
        for note in self.notes:
            print_error(note)


def solve_all(problem: Problem, planners: Sequence[str] | None, trials: Trials, title: str) -> None:
    """Print the plans of planners for a problem."""
    known = SOLVERS if problem.headings is None else HEADED_SOLVERS
    names, graph = planners or list(known), problem.graph
    solvers = [make_solver(name, trials.seed, problem, trials.seconds) for name in names]
    total, longest = problem.lower_bound, max(problem.fewest_steps.tolist(), default=0)
    trials.rows.append(("lower bound", str(longest), str(total), "1.000", "", ""))
    for name, solve in zip(names, solvers, strict=True):
        begin = time.perf_counter()
        try:
            plan, seconds, _ = solve_checked(name, solve, problem, trials.seconds)
        except PlanError as error:
            trials.notes.append(f"{name}: {error}")
            trials.rows.append((name, *["none"] * 3, "", f"{time.perf_counter() - begin:.3f}"))
            continue
        cost = plan.sum_of_costs
        ratio = cost / total if total else 1.0
        proved = "" if plan.bound is None else str(plan.bound)
        measures = str(plan.makespan), str(cost), f"{ratio:.3f}", proved, f"{seconds:.3f}"
        record, headings = record_of_plan(plan), plan.headings
        trials.add(name, measures, graph, plan.cells, record, cost, [seconds], headings=headings)
    trials.show(
        ("planner", "makespan", "sum of costs", "times the bound", "proved bound", "seconds"),
        f"{counted(problem.robots, 'robot')}, {title}",
        "lower bound: the longest of the shortest ways, and their sum; "
        "proved bound: no plan has a lower sum of costs",
    )
    if len(trials.notes) == len(names):
        raise typer.Exit(1)


def run_all(
    graph: Graph,
    planners: Sequence[str] | None,
    trials: Trials,
    start: Callable[[Planner], LifelongRun],
    title: str,
) -> None:
    """Print how many goals planners reach in lifelong runs."""
    run = start(Unhindered(graph))
    most, steps, robots = run.reached, len(run.seconds), run.cells.shape[1]
    names = planners or STEPPERS
    steppers = [
        make_stepper(name, trials.seed, graph.layout, robots, trials.seconds) for name in names
    ]
    trials.rows.append((BOUND, str(most), f"{most / steps:.3f}", "", "", ""))
    for name, stepper in zip(names, steppers, strict=True):
        run = start(stepper)
        share = f"{run.reached / most:.1%}" if most else ""
        times = [f"{1000 * of(run.seconds):.2f}" for of in (np.mean, np.max)]
        measures = str(run.reached), f"{run.throughput:.3f}", share, *times
        cost, lost, record = run.cells[1:].size, stepper.lost, record_of_run(run)
        trials.add(name, measures, graph, run.cells, record, cost, run.seconds.tolist(), lost)
        if lost:
            trials.notes.append(
                f"warning: {name}: {counted(len(lost), 'step')} took more than "
                f"{trials.seconds:g} s, first step {lost[0]}; all robots waited"
            )
    trials.show(
        ("planner", "goals reached", "a step", "of the bound", "ms a step", "longest ms"),
        title,
        f"{BOUND}: each robot by a shortest way, as if it were alone",
    )
