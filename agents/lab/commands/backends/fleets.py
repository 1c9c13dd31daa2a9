"""Comparison of a fleet in four worlds, for ``warehouse compare backends --robots N``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import typer

from agents.lab.commands.backends.measures import losses, table_of, write_page, write_values
from agents.lab.commands.backends.trial import (
    WORLDS,
    Setting,
    draw_orders,
    make_env,
    make_world,
    run_trial,
)
from agents.lab.console.table import print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.parameters import Number
from agents.lab.trials.workers import run_trials
from agents.registry import make_fleet_agent
from warehouse_core import WarehouseError
from warehouse_core.wording import counted
from warehouse_core.world.named_layouts import DEPOT, find_layout

PAGE, DISTURBED = ".html", "0.05:60"


def compare_fleets(
    robots: int = 12,
    planner: str = "pibt:guidance=lanes",
    order_rate: float = 0.4,
    count: int = 40,
    layout: Path = Path(DEPOT),
    disturbed: str = DISTURBED,
    episodes: int = 4,
    seed: int = 0,
    jobs: int | None = None,
    save: Sequence[Path] = (),
) -> None:
    """Run the same fleet, orders and planner in all worlds, and print their measures and losses.

    An episode ends when all orders are delivered. Here ``order_rate`` is the mean number of orders
    per second.
    """
    if not order_rate:
        raise typer.BadParameter("--order-rate is 0; allowed: a number above 0")
    noise, stop = parse_disturbed(disturbed)
    setting = Setting(find_layout(layout), robots, planner, order_rate, count, noise, stop)
    check(setting, seed)
    seeds = range(seed, seed + episodes)
    needs_record = any(path.suffix.lower() == PAGE for path in save)
    call = partial(run_trial, setting=setting, kept=seed if needs_record else None)
    results = run_trials(call, WORLDS, seeds, jobs)
    scores = {world: [score for score, _ in runs] for world, runs in results.items()}
    which = f"seed {seed}" if episodes == 1 else f"seeds {seed} to {seeds[-1]}"
    title = (
        f"{counted(robots, 'robot')} ({planner}), {counted(count, 'order')} at {order_rate:g} per "
        f"second, layout {layout.stem}, disturbed: noise of {noise:.0%} and a stop of {stop:g} s, "
        f"{which}"
    )
    table = table_of(scores, title)
    # Files first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        if path.suffix.lower() == PAGE:
            kept = {world: runs[0][1] for world, runs in results.items()}
            write_page(path, table, {world: each for world, each in kept.items() if each})
        else:
            write_values(path, scores, seeds)
    print_table(table)
    for loss in losses(scores, count):
        print_error(f"warning: {loss}")
    for path in save:
        say(f"saved {path}")


def parse_disturbed(text: str) -> tuple[float, float]:
    """Return the noise and the seconds of a stop in a text ``NOISE:SECONDS``."""
    try:
        noise, stop = map(float, text.split(":"))
        Number(0, 0.5)(noise)
        Number(0, math.inf)(stop)
    except ValueError:
        raise typer.BadParameter(
            f"--disturbed is {text!r}; it must be a share 0..0.5 and seconds, such as {DISTURBED}"
        ) from None
    return noise, stop


def check(setting: Setting, seed: int) -> None:
    """Raise an error before anything runs if the fleet of a setting cannot be made."""
    try:
        make_fleet_agent(setting.planner, None, seed, setting.layout, 1)
        orders = draw_orders(setting, seed)
        for name in WORLDS:
            make_env(setting, make_world(name, setting, orders[-1].released, seed), orders).close()
    except WarehouseError:
        raise
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
