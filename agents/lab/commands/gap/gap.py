"""The command ``warehouse gap``."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.gap.summary import SeedScores, gap_table, losses, message
from agents.lab.commands.gap.trial import Score, Setting, make_env, run_trial
from agents.lab.commands.gap.worlds import WORLDS, Shocks, make_world
from agents.lab.commands.planners.compare_planners import SeedsOption
from agents.lab.console import options
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.table import print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.values import parse_battery, parse_due
from agents.lab.trials.interval import MIN_VALUES
from agents.lab.trials.workers import run_trials
from agents.registry import PLANNERS, make_fleet_agent
from warehouse_core import WarehouseError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.orders.order import MAX_ORDERS
from warehouse_core.wording import counted
from warehouse_core.world.named_layouts import DEPOT, find_layout

DUE = 100, 300
PAGE, VALUES = ".html", ".csv"


def gap(
    robots: options.RobotsOption = 12,
    planner: Annotated[
        str,
        option(
            "--planner NAME",
            f"Directs all robots: {', '.join(PLANNERS)}, or your own as file.py:Class.",
        ),
    ] = "pibt-lanes",
    assignment: options.AssignmentOption = None,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    orders: Annotated[
        float, option("--orders RATE", "Orders that arrive in a second on average.")
    ] = 0.4,
    count: Annotated[int, option("--count N", "Orders of a run.", (1, MAX_ORDERS))] = 40,
    due: Annotated[
        str | None,
        option(
            "--due FEWEST:MOST", f"Seconds from release to due time. Default: {DUE[0]}:{DUE[1]}."
        ),
    ] = None,
    layout: options.FleetLayout = Path(DEPOT),
    battery: options.FleetBattery = "30000joules",
    noise: Annotated[
        float,
        option(
            "--noise SHARE",
            "Disturbed: standard deviation of the robots' speeds, as a share.",
            (0, 0.5),
        ),
    ] = 0.05,
    stop: Annotated[
        float,
        option(
            "--stop SECONDS",
            "Disturbed: one robot stands still for so long; 0: none, inf: it dies.",
            (0, None),
        ),
    ] = 60.0,
    seeds: SeedsOption = MIN_VALUES,
    seed: options.FirstSeed = 0,
    jobs: options.Jobs = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save FILE",
            "Write a page with the table, where time is lost, and all worlds side by side, "
            "as .html; or the values of each run, as .csv. May be given more than once.",
            callback=writable(PAGE, VALUES),
            **MANY,
        ),
    ],
) -> None:
    """Compare what a plan promises with what bodies do.

    The same fleet, orders and planner on the grid, on bodies that stop in
    every cell, on bodies that drive through, and on these with disturbances.
    A run ends when all orders are delivered. Orders come and are due at the
    same seconds in all worlds; a joint step of bodies that stop is taken to
    last as long as the move of a loaded robot.

    Example: warehouse gap --robots 12 --seeds 3 --save gap.html
    """
    if not 0 < orders < float("inf"):
        raise typer.BadParameter(f"--orders is {orders:g}; it must be above 0 orders a second")
    setting = Setting(
        find_layout(layout), robots, planner, assignment, plan_seconds, parse_battery(battery),
        orders, count, parse_due(due, DUE, "seconds"), Shocks(noise, stop),
    )  # fmt: skip
    check(setting, seed)
    numbers, keeps = range(seed, seed + seeds), any(path.suffix == PAGE for path in save)
    call = partial(run_trial, setting=setting, kept=seed if keeps else None)
    results = run_trials(call, WORLDS, numbers, jobs)
    scores = {world: [each.score for each in runs] for world, runs in results.items()}
    title = title_of(setting, layout.stem, numbers)
    table = gap_table(scores, title)
    # Files first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        if path.suffix == PAGE:
            from agents.lab.commands.gap.page import write_gap_page  # imports matplotlib

            kept = ((world, runs[0].record) for world, runs in results.items())
            records = {world: record for world, record in kept if record is not None}
            write_gap_page(path, setting, scores, table, records)
        else:
            write_values(path, scores, numbers)
    print_table(table)
    say(f"{message(scores, setting.shocks)}.")
    for loss in losses(scores, count):
        print_error(f"warning: {loss}")
    for path in save:
        say(f"saved {path}")


def check(setting: Setting, seed: int) -> None:
    """Raise before any run if the fleet of a setting cannot be made."""
    try:
        make_fleet_agent(setting.planner, setting.assignment, seed, setting.layout, 1)
        orders = setting.orders(seed)
        for name in WORLDS:
            world = make_world(name, setting.shocks, setting.robots, orders[-1].released, seed)
            make_env(setting, world, orders).close()
    except WarehouseError:
        raise
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def title_of(setting: Setting, layout: str, seeds: Sequence[int]) -> str:
    """Return what was run."""
    which = f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"
    robots, orders = counted(setting.robots, "robot"), counted(setting.count, "order")
    return (
        f"{robots} ({setting.planner}), {orders} at {setting.rate:g} a second, layout {layout}, "
        f"{which}"
    )


def write_values(path: Path, scores: SeedScores, seeds: Sequence[int]) -> None:
    """Write a line for each run, whole or not at all."""
    from agents.lab.commands.gap.spent_time import KINDS

    names = [name for name in Score._fields if name != "spent"]
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        spent = [f"seconds a delivery {kind}" for kind in KINDS]
        writer.writerow(["world", "seed", *names, *spent])
        for world, runs in scores.items():
            for seed, run in zip(seeds, runs, strict=True):
                values = [getattr(run, name) for name in names]
                writer.writerow([world, seed, *values, *run.spent])
