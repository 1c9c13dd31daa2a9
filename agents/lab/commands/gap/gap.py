"""The command ``warehouse gap``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from agents.fleet.planned import PLAN_SECONDS
from agents.lab.commands.gap.summary import SeedScores, gap_table, losses, message
from agents.lab.commands.gap.trial import Score, Setting, make_env, run_trial
from agents.lab.commands.gap.worlds import WORLDS, Shocks, make_world
from agents.lab.console import options
from agents.lab.console.csv_file import write_csv
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.table import print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.values import parse_battery, parse_due
from agents.lab.parameters import Number, Whole
from agents.lab.trials.workers import run_trials
from agents.registry import make_fleet_agent
from warehouse_core import WarehouseError
from warehouse_core.orders.order import MAX_ORDERS
from warehouse_core.wording import counted
from warehouse_core.world.named_layouts import DEPOT, find_layout

PAGE, VALUES = ".html", ".csv"


def gap(
    robots: options.RobotsOption = 12,
    planner: Annotated[
        str,
        option(
            "--planner NAME",
            options.PLANNER,
        ),
    ] = "pibt-lanes",
    assignment: options.AssignmentOption = None,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    order_rate: options.OrderRate = 0.4,
    count: Annotated[int, option("--count N", "Orders of an episode.", Whole(1, MAX_ORDERS))] = 40,
    due: options.Due = "100:300",
    layout: options.FleetLayout = Path(DEPOT),
    battery: options.FleetBattery = "30000joules",
    noise: Annotated[
        float,
        option(
            "--noise SHARE",
            "Standard deviation of the disturbed robots' speeds, as a share, up to 0.5.",
            Number(0, 0.5),
        ),
    ] = 0.05,
    stop: Annotated[
        float,
        option(
            "--stop SECONDS",
            "Seconds that one disturbed robot stands still. With 0 none does, with inf it dies.",
            Number(0, math.inf),
        ),
    ] = 60.0,
    episodes: options.Episodes = 4,
    seed: options.Seed = 0,
    jobs: options.Jobs = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} A page with the table, where time is lost, and all worlds side by "
            "side as .html, the values of each episode as .csv; may be repeated.",
            callback=writable(PAGE, VALUES),
            **MANY,
        ),
    ],
) -> None:
    """Compare a plan with what bodies do.

    The same fleet, orders and planner on the grid, on bodies that stop in
    every cell, on bodies that drive through, and on these with disturbances.
    A row of bodies that drive through each other, each as if alone on the floor,
    tells what traffic costs. An episode ends when all orders are delivered. A
    step of --order-rate and --due is 1 s, one of the plan: orders come and are
    due at the same seconds in all worlds. A joint step of bodies that stop lasts
    as long as the move of a loaded robot; bodies that drive through are planned
    for in quarters of 1 s.

    By default this takes about 25 s. Give -n 20 for 95% intervals, in five times
    as long.

    Example: warehouse gap --robots 8 --count 20 -n 3 --save gap.html
    """
    if not order_rate:
        raise typer.BadParameter("--order-rate is 0; allowed: a number above 0")
    setting = Setting(
        find_layout(layout), robots, planner, assignment, plan_seconds, parse_battery(battery),
        order_rate, count, parse_due(due), Shocks(noise, stop),
    )  # fmt: skip
    check(setting, seed)
    numbers, keeps = range(seed, seed + episodes), any(path.suffix == PAGE for path in save)
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
    """Write a line for each run."""
    from agents.lab.commands.gap.spent_time import KINDS

    names = [name for name in Score._fields if name != "spent"]
    spent = [f"seconds a delivery {kind}" for kind in KINDS]
    lines = (
        [world, seed, *(getattr(run, name) for name in names), *run.spent]
        for world, runs in scores.items()
        for seed, run in zip(seeds, runs, strict=True)
    )
    write_csv(path, ["world", "seed", *names, *spent], lines)
