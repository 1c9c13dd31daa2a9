"""Comparison of planners on many problems, for ``warehouse compare planners``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.errors import PlanError
from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.planners.runs import (
    BOUND,
    KIVA,
    STEPPERS,
    Attempt,
    CheckedPlanner,
    Unhindered,
    attempt,
    find_floor,
    find_scenarios,
    make_stepper,
    scenario_problem,
)
from agents.lab.console.output import save_picture
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.values import parse_sizes
from agents.lab.trials.interval import (
    MIN_VALUES,
    Interval,
    above_interval,
    mean_interval,
    share_interval,
)
from agents.lab.trials.workers import run_trials
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from warehouse_core.files.tables import write_table
from warehouse_core.wording import counted
from warehouse_core.world.scenarios import load_scenarios

SIZES = (32, 64, 96, 128, 160, 192)

FIRST_SIZE = 10
"""Smallest default number of robots on scenarios; each further number is twice as large."""

VALUES = ".csv"


class PlannerOutcome(NamedTuple):
    """The outcome of a lifelong run.

    Attributes:
        throughput: goals reached per step.
        milliseconds: mean planning time per step in ms.
        lost: number of steps whose planning was cut off.
    """

    throughput: float
    milliseconds: float
    lost: int


PlannerCase = tuple[str, int]
"""Name of a planner, or ``BOUND``, and number of robots."""


class PlannerTrials(NamedTuple):
    """The trials of planners with several numbers of robots, and their presentation.

    Attributes:
        outcomes: outcomes of each case, one for each of ``labels``.
        labels: seeds or files of the trials.
        label: title of the column with the labels.
        shown: value of each case in the figure, and its text in the table.
        measure: title of the vertical axis of the figure.
        title: title of the table and the figure.
        caption: note below the table.
    """

    outcomes: Mapping[PlannerCase, Sequence[PlannerOutcome | Attempt]]
    labels: Sequence[object]
    label: str
    shown: Mapping[PlannerCase, tuple[Interval, str]]
    measure: str
    title: str
    caption: str


def compare_planners(
    files: Sequence[Path] = (),
    planner: Sequence[str] = (),
    robots: str | None = None,
    episodes: int = 5,
    layout: Path | None = None,
    lifelong: int = 256,
    plan_seconds: float = PLAN_SECONDS,
    jobs: int | None = None,
    save: Sequence[Path] = (),
) -> None:
    """Compare planners with several fleet sizes and seeds, or on scenarios if there are ``files``.

    In a lifelong run a robot that reaches its goal gets another one, until ``lifelong`` steps have
    passed. The table shows the goals reached per step, next to a bound. For scenarios it shows the
    number of problems that are solved within ``plan_seconds``.
    """
    name = None if layout is None else str(layout)
    sizes = parse_sizes(robots) if robots is not None else []
    if files:
        names = list(dict.fromkeys(planner or ["lacam"]))
        trials = solve_scenarios(names, sizes, find_scenarios(files), name, plan_seconds, jobs)
    else:
        names = list(dict.fromkeys(planner or STEPPERS))
        call = partial(run_trial, layout=name, steps=lifelong, seconds=plan_seconds)
        trials = run_all(names, sizes or list(SIZES), call, episodes, jobs)
    # Files first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        write_trials(path, trials)
    print_table(table_of(trials))
    for (name, size), outcomes in trials.outcomes.items():
        lost = sum(each.lost for each in outcomes if isinstance(each, PlannerOutcome))
        if lost:
            print_error(
                f"warning: {name}, {counted(size, 'robot')}: {counted(lost, 'step')} took "
                f"more than {plan_seconds:g} s; all robots waited"
            )
    for path in save:
        say(f"saved {path}")


def run_trial(
    case: PlannerCase, seed: int, *, layout: str | None, steps: int, seconds: float
) -> PlannerOutcome:
    """Return the outcome of a lifelong run that allows ``seconds`` for planning each step."""
    (name, robots), floor = case, find_floor(layout)
    graph = Graph(floor.layout)
    planner: Unhindered | CheckedPlanner = Unhindered(graph)
    if name != BOUND:
        planner = make_stepper(name, seed, floor.layout, robots, seconds)
    run = run_lifelong(graph, planner, robots, steps, seed, floor.starts, floor.goals)
    lost = len(planner.lost) if isinstance(planner, CheckedPlanner) else 0
    return PlannerOutcome(run.throughput, 1000 * float(run.seconds.mean()), lost)


def run_all(
    names: Sequence[str],
    sizes: Sequence[int],
    call: partial[PlannerOutcome],
    episodes: int,
    jobs: int | None,
) -> PlannerTrials:
    """Return the lifelong runs of all planners and of the bound."""
    layout, steps, seconds = (call.keywords[name] for name in ("layout", "steps", "seconds"))
    floor = find_floor(layout)
    for name in names:
        # A wrong name is an error before the runs; planners that learn start fastest for one robot.
        make_stepper(name, 0, floor.layout, 1, seconds)
    if max(sizes) > len(floor.starts):
        raise PlanError(
            f"--robots has {max(sizes)}; allowed: 1 to {len(floor.starts)}, the number of start "
            "cells"
        )
    outcomes = run_trials(call, list(product((*names, BOUND), sizes)), range(episodes), jobs)

    shown = {}
    for case, found in outcomes.items():
        rates, milliseconds, _ = np.array(found).T
        rate = mean_interval(rates) or Interval(math.nan)
        words = f"{above_interval(rate)}\n{milliseconds.mean():.1f} ms per step"
        shown[case] = rate, f"{rate.estimate:.2f}" if case[0] == BOUND else words
    title = (
        f"Goals reached per step: layout {layout or KIVA}, {counted(steps, 'step')}, "
        f"{counted(episodes, 'seed')} from 0"
    )
    few = f"Intervals need at least {MIN_VALUES} episodes." if episodes < MIN_VALUES else ""
    measure = "goals reached per step"
    return PlannerTrials(outcomes, range(episodes), "seed", shown, measure, title, few)


def solve_scenarios(
    names: Sequence[str],
    sizes: Sequence[int],
    files: Sequence[Path],
    layout: str | None,
    seconds: float,
    jobs: int | None,
) -> PlannerTrials:
    """Return the attempts of planners at the first scenarios of each file.

    Raises:
        PlanError: a file has fewer scenarios than robots, or for the reasons of
            ``scenario_problem``.
    """
    least = min(len(load_scenarios(path)) for path in files)
    if not sizes:
        sizes = [FIRST_SIZE * 2**power for power in range(least.bit_length())]
        sizes = [size for size in sizes if size <= least] or [least]
    for path in files:
        scenario_problem(path, layout, max(sizes))  # so that errors appear before anything runs
    call = partial(attempt_at, files=files, layout=layout, seconds=seconds)
    outcomes = run_trials(call, list(product(names, sizes)), range(len(files)), jobs, "plans")

    shown = {}
    for case, found in outcomes.items():
        ratios = [each.costs / each.bound for each in found if each.costs and each.bound]
        solved, trials = sum(each.costs is not None for each in found), len(found)
        rate = Interval(solved / trials)
        if trials >= MIN_VALUES:
            rate = share_interval(solved, trials)
        costs = f"\n{np.mean(ratios):.3f}" if ratios else ""
        took = np.mean([each.seconds for each in found])
        shown[case] = rate, f"{solved} of {trials}{costs}\n{took:.3f} s"
    title = f"{counted(len(files), 'scenario file')}, {seconds:g} s per plan"
    caption = (
        "Each cell has the number of files with a plan for their first robots, the mean ratio of "
        "the costs to the sum of the fewest steps, and the mean processor time."
    )
    return PlannerTrials(outcomes, files, "file", shown, "scenarios solved", title, caption)


def attempt_at(
    case: PlannerCase, number: int, *, files: Sequence[Path], layout: str | None, seconds: float
) -> Attempt:
    """Return the attempt of a planner at the first scenarios of a file."""
    planner, robots = case
    return attempt(planner, 0, scenario_problem(files[number], layout, robots), seconds)


def table_of(trials: PlannerTrials) -> TextTable:
    """Return a table with a row for each number of robots, and a column for each planner."""
    names, sizes = (list(dict.fromkeys(column)) for column in zip(*trials.shown, strict=True))
    rows = [(str(size), *(trials.shown[name, size][1] for name in names)) for size in sizes]
    return TextTable(("robots", *names), rows, trials.title, trials.caption)


def write_trials(path: Path, trials: PlannerTrials) -> None:
    """Write a CSV file with a line for each trial, or a figure with a curve for each planner."""
    if path.suffix.lower() == VALUES:
        lines = [
            [name, size, str(label), *each]
            for (name, size), column in trials.outcomes.items()
            for label, each in zip(trials.labels, column, strict=True)
        ]
        fields = next(iter(trials.outcomes.values()))[0]._fields
        write_table(path, ["planner", "robots", trials.label, *fields], lines)
        return
    from agents.lab.trials.figure import curves_figure  # imports matplotlib

    curves = dict[str, dict[int, Interval]]()
    for (name, size), (rate, _) in trials.shown.items():
        curves.setdefault(name, {})[size] = rate
    save_picture(curves_figure(curves, trials.title, trials.measure, BOUND), path)
