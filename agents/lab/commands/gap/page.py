"""The page of ``warehouse gap``: the table, where time is lost, and all worlds on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from agents.fleet.planned import DEFAULT_ASSIGNMENT
from agents.lab.commands.gap.spent_time import KINDS, Times
from agents.lab.commands.gap.summary import SeedScores, message
from agents.lab.commands.gap.trial import Setting
from agents.lab.commands.gap.worlds import DRIVING, PLAN, STOPPING
from agents.lab.console import table as console
from agents.lab.reports.page import Table, write_template
from agents.lab.trials.interval import CONFIDENCE
from warehouse_core import FleetEpisode
from warehouse_core.viz.player import player_frame
from warehouse_core.viz.tracks import Track, track_of_record
from warehouse_core.wording import counted, listed

FRAME_SECONDS = 0.5
"""Simulated seconds from one frame of the replay to the next."""

SPEED = 2.0
"""Factor on the playing speed."""

HEIGHT = 860
"""Height of the replay in pixels."""

NOTE = (
    f"Means over the seeds; brackets are {CONFIDENCE:.0%} intervals, the studentised bootstrap's. "
    "The share of the plan's deliveries is a mean of the shares of each seed. Deliveries that are "
    "missing are not on time."
)


class Bar(NamedTuple):
    """The time of the robots of a world, in parts by what they spend it on, and as text.

    Attributes:
        width: width in percent of the longest bar.
        parts: seconds of each of ``KINDS``.
        total: seconds a delivery.
    """

    world: str
    width: float
    total: str
    parts: list[float]
    words: str


def write_gap_page(
    path: Path,
    setting: Setting,
    scores: SeedScores,
    table: console.TextTable,
    records: Mapping[str, FleetEpisode],
) -> None:
    """Write the page, whole or not at all, with the records of the first seed by world."""
    rows = tuple(tuple(cell.replace("\n", " ") for cell in row) for row in table.rows)
    note = " ".join(filter(None, (NOTE, table.caption)))
    tracks = [track_of(record, world) for world, record in records.items()]
    moment, heading = shown(records)
    replay = player_frame(
        tracks, title="All worlds on one clock", speed=SPEED, opens_at=moment, height=HEIGHT
    )
    write_template(
        path,
        "gap.html",
        message(scores, setting.shocks),
        has_players=True,
        summary=table.title,
        table=Table(table.header, rows, note),
        lost=lost(scores),
        kinds=KINDS,
        bars=bars_of(scores),
        shown=heading,
        replay=Markup(replay),
        settings=settings_of(setting),
    )


def track_of(record: FleetEpisode, world: str) -> Track:
    """Return the track of a record under the name of its world."""
    track = track_of_record(record, FRAME_SECONDS)
    track.title = world
    for frame in track.frames:
        frame.energy = 0.0  # the chart of all worlds has it
    track.lateness = ()  # in steps, which last differently long
    return track


def spent_of(scores: SeedScores, world: str) -> Times:
    """Return the seconds a delivery that a world spends on each of ``KINDS``, means."""
    found: Times = np.array([run.spent for run in scores[world]]).mean(axis=0)
    return found


def bars_of(scores: SeedScores) -> list[Bar]:
    """Return a bar for each world."""
    spent = {world: spent_of(scores, world) for world in scores}
    longest = max(float(each.sum()) for each in spent.values())
    bars = []
    for world, each in spent.items():
        parts = [round(seconds, 3) for seconds in each.tolist()]
        total = float(each.sum())
        words = ", ".join(
            f"{kind} {seconds:.1f} s" for kind, seconds in zip(KINDS, parts, strict=True)
        )
        bars.append(Bar(world, round(100 * total / longest, 2), f"{total:.0f}", parts, words))
    return bars


def lost(scores: SeedScores) -> str:
    """Return what speeding up and braking cost."""
    stopping, driving = (spent_of(scores, world)[1] for world in (STOPPING, DRIVING))
    return (
        f"Speeding up and braking cost {stopping:.0f} s a delivery where robots stop in every "
        f"cell, and {driving:.0f} s where they drive through"
    )


def shown(records: Mapping[str, FleetEpisode]) -> tuple[float, str]:
    """Return when the plan has delivered all orders, and how many each world has by then."""
    clocks = {
        world: np.concatenate([[0.0], record.seconds.max(axis=1).cumsum()])
        for world, record in records.items()
    }
    times = {
        world: [clocks[world][each.delivered] for each in record.orders if each.delivered]
        for world, record in records.items()
    }
    end = max(times[PLAN], default=0.0)
    counts = {world: sum(time <= end for time in each) for world, each in times.items()}
    others = [f"{world} {count:,}" for world, count in counts.items() if world != PLAN]
    plan = f"After {end:,.0f} s the plan has delivered {counted(counts[PLAN], 'order')}"
    return end, f"{plan}, {listed(others)}"


def settings_of(setting: Setting) -> list[tuple[str, str]]:
    """Return the names and values of what the worlds have in common."""
    battery, shocks, due = setting.battery, setting.shocks, setting.due
    return [
        ("robots", f"{setting.robots}"),
        ("planner", setting.planner),
        ("assignment", setting.assignment or DEFAULT_ASSIGNMENT),
        ("battery", f"{battery.capacity:,} {battery.unit}"),
        ("orders", f"{setting.count:,}, {setting.rate:g} a second"),
        ("due", f"{due[0]:,} to {due[1]:,} s after the release"),
        ("disturbed", f"noise of {shocks.noise:.0%}, a stop of {shocks.stop:g} s"),
    ]
