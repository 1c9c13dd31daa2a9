"""Comparison of a fleet in four worlds, for ``warehouse compare backends --robots N``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import typer

from agents.lab.commands.backends.trial import (
    PLAN,
    WORLDS,
    Score,
    Setting,
    draw_orders,
    make_env,
    make_world,
    run_trial,
)
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.parameters import Number
from agents.lab.trials.interval import MIN_VALUES, Interval, above_interval, mean_interval
from agents.lab.trials.workers import run_trials
from agents.registry import make_fleet_agent
from warehouse_core import FleetEpisode, WarehouseError
from warehouse_core.files.tables import write_table
from warehouse_core.wording import counted, listed
from warehouse_core.world.named_layouts import DEPOT, find_layout

PAGE, DISTURBED = ".html", "0.05:60"

SeedScores = Mapping[str, Sequence[Score]]
"""Measures of each run by world; all worlds have the same seeds in the same order."""

Value = Callable[[Score, Score], float]
"""Function that returns a value of a run, given the run and the grid plan with the same seed."""

MEASURES: dict[str, Value] = {
    "deliveries per hour": lambda score, _: score.per_hour,
    "% of the plan": lambda score, plan: (
        100 * score.per_hour / plan.per_hour if plan.per_hour else math.nan
    ),
    "% on time": lambda score, _: 100 * score.on_time,
    "kJ per delivery": lambda score, _: score.joules / 1000,
    "last delivery (s)": lambda score, _: score.makespan,
    "hits": lambda score, _: score.hits,
}

FRAME_SECONDS, SPEED, HEIGHT = 0.5, 2.0, 860
"""Simulated seconds per frame of the replay, its playing speed, and its height in pixels."""


def compare_fleets(
    robots: str,
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
    if not robots.isdecimal():
        raise typer.BadParameter(f"--robots is {robots!r}; it must be one whole number")
    if not order_rate:
        raise typer.BadParameter("--order-rate is 0; allowed: a number above 0")
    noise, stop = parse_disturbed(disturbed)
    setting = Setting(find_layout(layout), int(robots), planner, order_rate, count, noise, stop)
    check(setting, seed)
    seeds = range(seed, seed + episodes)
    needs_record = any(path.suffix.lower() == PAGE for path in save)
    call = partial(run_trial, setting=setting, kept=seed if needs_record else None)
    results = run_trials(call, WORLDS, seeds, jobs)
    scores = {world: [score for score, _ in runs] for world, runs in results.items()}
    which = f"seed {seed}" if episodes == 1 else f"seeds {seed} to {seeds[-1]}"
    title = (
        f"{counted(setting.robots, 'robot')} ({planner}), {counted(count, 'order')} at "
        f"{order_rate:g} per second, layout {layout.stem}, disturbed: noise of {noise:.0%} and a "
        f"stop of {stop:g} s, {which}"
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


def table_of(scores: SeedScores, title: str) -> TextTable:
    """Return a table of the measures with a row for each world."""
    few = len(scores[PLAN]) < MIN_VALUES
    caption = f"Intervals need at least {MIN_VALUES} episodes." if few else ""
    rows = [
        (world, *(cell_of(runs, scores[PLAN], value) for value in MEASURES.values()))
        for world, runs in scores.items()
    ]
    return TextTable(("world", *MEASURES), rows, title, caption)


def cell_of(runs: Sequence[Score], plans: Sequence[Score], value: Value) -> str:
    """Format the mean of a value over the seeds, with its interval unless its width is 0."""
    values = np.array([value(score, plan) for score, plan in zip(runs, plans, strict=True)])
    mean = mean_interval(values[~np.isnan(values)]) or Interval(math.nan)
    if math.isnan(mean.estimate):  # a share of nothing
        return "none"
    if mean.estimate.is_integer() and (mean.low == mean.high or not mean.is_known):
        return f"{mean.estimate:,.0f}"
    return above_interval(mean)


def losses(scores: SeedScores, orders: int) -> list[str]:
    """Return a warning for each world with undelivered orders, lost robots or missing plans.

    Args:
        scores: measures of all runs.
        orders: number of orders in each run.
    """
    found = []
    for world, runs in scores.items():
        counts = {
            "order": ("not delivered", sum(orders - run.delivered for run in runs)),
            "robot": ("lost", sum(run.lost for run in runs)),
            "step": ("without a plan", sum(run.late_plans for run in runs)),
        }
        words = [
            f"{counted(number, noun)} {fate}" for noun, (fate, number) in counts.items() if number
        ]
        if words:
            found.append(f"{world}, in {counted(len(runs), 'episode')}: {listed(words)}")
    return found


def write_values(path: Path, scores: SeedScores, seeds: Sequence[int]) -> None:
    """Write a CSV file with a line for each run."""
    lines = (
        [world, seed, *run]
        for world, runs in scores.items()
        for seed, run in zip(seeds, runs, strict=True)
    )
    write_table(path, ["world", "seed", *Score._fields], lines)


def write_page(path: Path, table: TextTable, records: Mapping[str, FleetEpisode]) -> None:
    """Write a page with the table and a replay of the records of all worlds on one clock."""
    from markupsafe import Markup

    from agents.lab.reports.page import write_template  # imports matplotlib
    from warehouse_core.viz.player import player_frame
    from warehouse_core.viz.tracks import track_of_record

    tracks = []
    for world, record in records.items():
        track = track_of_record(record, FRAME_SECONDS)
        track.title, track.lateness = world, ()  # it is in steps, whose length differs by world
        for frame in track.frames:
            frame.energy = 0.0  # the chart of all worlds shows the energy
        tracks.append(track)
    title = "A fleet on the grid and on rigid bodies"
    rows = [tuple(cell.replace("\n", " ") for cell in row) for row in table.rows]
    replay = player_frame(tracks, title=title, speed=SPEED, height=HEIGHT)
    write_template(
        path, "backends.html", title, has_players=True,
        summary=table.title, table=table._replace(rows=rows), replay=Markup(replay),
    )  # fmt: skip
