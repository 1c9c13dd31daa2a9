"""The worlds in which one agent runs side by side, for ``warehouse race --worlds``."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import typer

from agents.code_names import split_name
from warehouse_core import Cell, Episode
from warehouse_core.motion.base import centre_of
from warehouse_core.records.drive_summary import DriveSummary, drive_summary
from warehouse_core.records.episode import DELIVERED, DRIVE
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.tracks.timeline import ghost_of
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted, seconds_of
from warehouse_core.world.actions import DISPLACEMENTS, action_index
from warehouse_core.world.tiles import moved

GRID, DRIVING, ICY = "grid", "driving", "icy"

ICE = "physics:grip=0.05"
"""Backend of the icy world: wet ice, on which the motor can push with at most 5% of the weight."""

TITLES = {
    GRID: "Grid: jumps from cell to cell",
    "physics": "Physics: a body with mass",
    DRIVING: "Driving: the same path in one go",
    DRIVE: "Drive: speeds and turn rates",
    ICY: "Icy: a body on a slippery floor",
}
"""Titles of the replays of worlds."""

MANNERS = {"physics": "move by move", DRIVING: "driving through", DRIVE: "steered"}
"""Manner in which a body carries out an episode, by the name of its backend."""

GRID_SECONDS = 2.0
"""Duration of a step of the grid on the clock of the replay. The grid has no seconds of its own, so
a step takes as long as the default body needs for a cell."""

FRAME_SECONDS = 0.25
"""Simulated seconds between frames of the replay, so that the files of four worlds stay small."""

NO_VALUE = "-"
"""Text of a value that a world does not have."""


def split_worlds(text: str) -> list[str]:
    """Return the names of worlds in a text such as ``grid,physics:mass=90,drive=differential,icy``.

    A part with ``=`` but without ``:`` is a further setting of the world before it, unless it is
    an existing file, or this world has no settings.
    """
    worlds: list[str] = []
    for part in text.split(","):
        is_setting = "=" in part and ":" not in part and not os.path.isfile(part)
        if is_setting and worlds and split_name(worlds[-1]).options:
            worlds[-1] += f",{part}"
        elif not part or part in worlds:
            what = f"names {part} twice" if part else f"is {text!r}"
            raise typer.BadParameter(f"--worlds {what}; allowed: names as in grid,physics,icy")
        else:
            worlds.append(part)
    return worlds


class Miss(NamedTuple):
    """A move to a free cell after which the robot was in another cell.

    Attributes:
        step: number of the step, from 1.
        target: cell that the robot was to reach.
        short: distance in metres by which the robot missed the middle of this cell, along its
            direction of motion. It is negative if the robot slid past.
    """

    step: int
    target: Cell
    short: float

    @property
    def where(self) -> str:
        """Where the robot came to rest, in words."""
        return f"{abs(self.short):.1f} m {'past' if self.short < 0 else 'short of'} {self.target}"


def misses(record: Episode) -> Iterator[Miss]:
    """Yield the moves of a robot that did not end in their target cells.

    Under continuous control there are no such moves.
    """
    if record.is_driven:
        return
    for step, (action, motion) in enumerate(zip(record.actions, record.motions, strict=True), 1):
        down, right = DISPLACEMENTS[action_index(action)]
        before, after = record.cells[step - 1 : step + 1]
        target = moved(before, (down, right))
        if after == target or not record.layout.is_open(target):
            continue
        x, y = centre_of(target, record.cell_size)
        end_x, end_y = motion.path[-1, 1:3]
        yield Miss(step, target, float((x - end_x) * right + (y - end_y) * down))


def world_sentences(records: Mapping[str, Episode]) -> list[str]:
    """Return a sentence for each world that differs from the grid, or one if none does.

    Without the grid, worlds are compared with the first one.
    """
    plan = GRID if GRID in records else next(iter(records))
    found = [
        world_sentence(world, record, records[plan])
        for world, record in records.items()
        if world != plan
    ]
    return [*filter(None, found)] or ["The robot visits the same cells in all worlds."]


def world_sentence(world: str, record: Episode, planned: Episode) -> str:
    """Return where and why a world differs from another one, or "" if it does not.

    Args:
        world: name of the world.
        record: record in this world.
        planned: record of the same agent in the other world.
    """
    miss = next(misses(record), None)
    if miss is None:
        is_same = record.cells == planned.cells
        return "" if is_same else f"{world}: {diagnose(record).sentence}."
    here, end = record.cells[miss.step - 1 : miss.step + 1]
    ended = "slid" if miss.short < 0 else "came to rest"
    cause = ""
    if not {here, miss.target, end}.isdisjoint(record.slippery):
        cause = " on the slippery floor"
    elif record.motor_strength < 1:
        cause = f" with {record.motor_strength:.0%} of its force"
    return (
        f"{world}: in step {miss.step} at {here}, the robot {ended} {miss.where}{cause}. "
        f"{_what_followed(record, planned)}."
    )


def _what_followed(record: Episode, planned: Episode) -> str:
    """Return what the agent did after its first miss."""
    if record.outcome == DELIVERED:
        steps = counted(record.steps, "step")
        return f"The agent looked where it was, and delivered in {steps} instead of {planned.steps}"
    both = min(record.steps, planned.steps)
    if record.actions[:both] != planned.actions[:both]:
        return f"In the end: {diagnose(record).sentence}"
    hits = sum(len(motion.contacts) for motion in record.motions)
    bumped = ("", "hit a wall, ")[hits] if hits < 2 else f"hit walls {hits} times, "
    item = "with the item" if record.loaded[-1] else "without the item"
    return f"Its plan went on as if it had arrived, {bumped}and ended at {record.cells[-1]} {item}"


DRIVE_ROWS: dict[str, Callable[[DriveSummary], str]] = {
    "seconds": lambda summary: seconds_of(summary.seconds),
    "joules": lambda summary: f"{summary.joules:,.0f}",
    "distance (m)": lambda summary: f"{summary.distance:.1f}",
    "highest speed (m/s)": lambda summary: f"{summary.top_speed:.2f}",
    "stops": lambda summary: str(summary.stops),
    "hits": lambda summary: str(summary.hits),
    "largest impulse (N·s)": lambda summary: (
        f"{summary.largest_impulse:.1f}" if summary.hits else NO_VALUE
    ),
}
"""Texts of what a body measured, by name."""


def result_rows(records: Sequence[Episode]) -> list[tuple[str, ...]]:
    """Return a row for each result, with a value for each record. The grid measures nothing."""
    summaries = [*map(drive_summary, records)]
    rows = [
        ("outcome", *(record.outcome for record in records)),
        ("steps", *(str(record.steps) for record in records)),
        ("total reward", *(f"{record.total_reward:.2f}" for record in records)),
    ]
    if any(summaries):
        for name, value in DRIVE_ROWS.items():
            rows.append((name, *(NO_VALUE if each is None else value(each) for each in summaries)))
    return rows


def story_of_worlds(records: Mapping[str, Episode]) -> str:
    """Return sentences that compare what the worlds measured, and the cells that were visited."""
    parts = []
    for world, record in records.items():
        summary, name = drive_summary(record), split_name(world).source
        if summary is None:
            parts.append(f"The {world} counts {counted(record.steps, 'step')}.")
            continue
        manner = MANNERS.get(name, f"with {name}")
        parts.append(
            f"{manner.capitalize()}, the body needs {seconds_of(summary.seconds)} s and "
            f"{summary.joules / 1000:.1f} kJ and stops {counted(summary.stops, 'time')}."
        )
    paths = [record.cells for record in records.values()]
    is_same = all(path == paths[0] for path in paths)
    all_of_them = {2: "Both", 3: "All three", 4: "All four"}.get(len(paths), f"All {len(paths)}")
    parts.append(f"{all_of_them} visit {'the same' if is_same else 'different'} cells.")
    return " ".join(parts)


def on_one_clock(records: Mapping[str, Episode], tracks: Iterable[Track]) -> list[Track]:
    """Return the tracks of worlds, titled, with a clock for the grid; see ``GRID_SECONDS``.

    Each body that ends no earlier than the grid has a ghost where the robot of the grid is. The
    last caption of a world in which a plan fails says where it began to fail.
    """
    in_worlds = dict(zip(records, tracks, strict=True))
    for world, track in in_worlds.items():
        track.title = TITLES.get(world, world)
        miss = next(misses(records[world]), None)
        if miss is not None and records[world].outcome != DELIVERED:
            track.frames[-1].caption = f"Step {miss.step} ended {miss.where}"
        if world == GRID:
            for frame in track.frames:
                frame.clock = frame.progress * GRID_SECONDS
    if GRID in in_worlds:
        last = in_worlds[GRID].frames[-1].clock
        for track in in_worlds.values():
            if track.is_continuous and track.frames[-1].clock >= last:
                track.ghost = ghost_of(track, in_worlds[GRID])
    return [*in_worlds.values()]
