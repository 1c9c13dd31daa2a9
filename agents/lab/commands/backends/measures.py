"""The measures of a fleet in all worlds, as a table, a page and a file of values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from agents.lab.commands.backends.trial import PLAN, Score
from agents.lab.console.table import TextTable
from agents.lab.trials.interval import MIN_VALUES, Interval, mean_interval
from agents.lab.trials.wording import above_interval
from warehouse_core import FleetEpisode
from warehouse_core.files.tables import write_table
from warehouse_core.wording import counted, listed

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
