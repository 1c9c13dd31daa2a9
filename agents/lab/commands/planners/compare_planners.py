"""The command ``warehouse compare planners``: throughput over fleet sizes and seeds."""

from __future__ import annotations

import math
from functools import partial
from itertools import product
from typing import Annotated, NamedTuple

import numpy as np

from agents.errors import PlanError
from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.planners.floors import KIVA, FloorOption, find_floor
from agents.lab.commands.planners.mapf import LIFELONG, PLANNER
from agents.lab.commands.planners.runs import (
    BOUND,
    STEPPERS,
    CheckedPlanner,
    Unhindered,
    make_stepper,
)
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.output import save_picture
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.values import parse_sizes
from agents.lab.parameters import Whole
from agents.lab.trials.interval import MIN_VALUES, Interval, mean_interval
from agents.lab.trials.wording import above_interval
from agents.lab.trials.workers import run_trials
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from warehouse_core.wording import counted

SIZES = "32,64,96,128,160,192"


class PlannerOutcome(NamedTuple):
    """Goals that were reached in a step, milliseconds of a step, and steps that were cut off."""

    throughput: float
    milliseconds: float
    lost: int


PlannerCase = tuple[str, int]
"""A planner, or ``BOUND``, and a number of robots."""


def run_trial(
    case: PlannerCase, seed: int, *, layout: str | None, steps: int, seconds: float
) -> PlannerOutcome:
    """Return the outcome of a run in which a step is cut off after some seconds."""
    (name, robots), floor = case, find_floor(layout)
    graph = Graph(floor.layout)
    planner: Unhindered | CheckedPlanner = Unhindered(graph)
    if name != BOUND:
        planner = make_stepper(name, seed, floor.layout, robots, seconds)
    run = run_lifelong(graph, planner, robots, steps, seed, floor.starts, floor.goals)
    lost = len(planner.lost) if isinstance(planner, CheckedPlanner) else 0
    return PlannerOutcome(run.throughput, 1000 * float(run.seconds.mean()), lost)


def compare_planners(
    planner: Annotated[
        list[str] | None, option("--planner NAME", PLANNER, show_default=False)
    ] = None,
    robots: Annotated[
        str,
        option("--robots -r N,N", f"{options.ROBOTS} Several, separated by commas."),
    ] = SIZES,
    episodes: options.Episodes = 5,
    seed: options.Seed = 0,
    layout: FloorOption = None,
    steps: Annotated[int, option("--lifelong N", LIFELONG, Whole(1))] = 256,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    jobs: options.Jobs = None,
    save: options.SaveFigure = None,
) -> None:
    """Compare planners over fleet sizes and seeds.

    In a lifelong run a robot that reaches its goal gets another. Prints the
    goals that are reached in a step, beside a bound.

    By default this takes about 15 s. Give -n 20 for 95% intervals, in four
    times as long; windowed planners take long for many robots.

    Example: warehouse compare planners --planner pibt --planner windowed -r 32,64
    """
    sizes = parse_sizes(robots)
    names = list(dict.fromkeys(planner or STEPPERS))
    floor = find_floor(layout)
    for name in names:
        # A wrong name is an error at once; planners that learn take least time for one robot.
        make_stepper(name, seed, floor.layout, 1, plan_seconds)
    if max(sizes) > len(floor.starts):
        raise PlanError(
            f"--robots has {max(sizes)}; allowed: 1 to {len(floor.starts)}, the cells to start from"
        )
    call = partial(run_trial, layout=layout, steps=steps, seconds=plan_seconds)
    cases = list(product((*names, BOUND), sizes))
    outcomes = run_trials(call, cases, range(seed, seed + episodes), jobs)
    rates, times, lost = (
        dict[PlannerCase, Interval](),
        dict[PlannerCase, float](),
        dict[PlannerCase, int](),
    )
    for case, each in outcomes.items():
        throughputs, milliseconds, cut_off = np.array(each).T
        rates[case] = mean_interval(throughputs) or Interval(math.nan)
        times[case], lost[case] = float(milliseconds.mean()), int(cut_off.sum())
    title = (
        f"Goals reached in a step: layout {layout or KIVA}, {counted(steps, 'step')}, "
        f"{counted(episodes, 'seed')} from {seed}"
    )
    # The picture first, because the reader of standard output may leave, as ``head`` does.
    if save is not None:
        from agents.lab.commands.planners.picture import curves_figure

        curves = {name: {size: rates[name, size] for size in sizes} for name in (*names, BOUND)}
        save_picture(curves_figure(curves, title, "goals reached in a step", BOUND), save)
    rows = []
    for size in sizes:
        cells = [
            f"{above_interval(rates[name, size])}\n{times[name, size]:.1f} ms a step"
            for name in names
        ]
        rows.append((str(size), *cells, f"{rates[BOUND, size].estimate:.2f}"))
    few = episodes < MIN_VALUES
    caption = f"Fewer than {MIN_VALUES} episodes have no intervals." if few else ""
    print_table(TextTable(("robots", *names, BOUND), rows, title, caption))
    for (name, size), count in lost.items():
        if count:
            print_error(
                f"warning: {name}, {counted(size, 'robot')}: {counted(count, 'step')} took "
                f"more than {plan_seconds:g} s; all robots waited"
            )
    if save is not None:
        say(f"saved {save}")
