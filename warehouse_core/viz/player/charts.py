"""The charts of a page: what ``player/charts.js`` draws, without knowing what it means."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Literal

from warehouse_core.viz.player.columns import Columns
from warehouse_core.viz.tracks.track import Track
from warehouse_core.world.tiles import DROPOFF, PICKUP

Kind = Literal["line", "thin", "steps", "bars", "dots"]

INK, WARNING = "ink", "warning"
"""Names of colours that are not those of a tile."""


@dataclass(frozen=True)
class Series:
    """Numbers in a chart: its title, their name, how they are drawn, their times and themselves."""

    chart: str
    name: str
    kind: Kind
    color: str
    times: Sequence[float]
    values: Sequence[float]


def packed_charts(
    tracks: Sequence[Track], times: Sequence[Sequence[float]], columns: Columns
) -> list[dict[str, Any]]:
    """Return the charts of some tracks; those of the same title are one chart.

    Args:
        tracks: to be drawn.
        times: for each track those of its frames.
        columns: where the numbers are added.
    """
    charts: dict[str, list[dict[str, Any]]] = {}
    for number, (track, moments) in enumerate(zip(tracks, times, strict=True)):
        for series in _series_of(track, moments):
            if len(tracks) > 1 and (series.kind == "bars" or not len(series.times)):
                continue  # bars would hide each other
            charts.setdefault(series.chart, []).append(
                {
                    "track": number,
                    "name": series.name,
                    "kind": series.kind,
                    "color": series.color,
                    "x": columns.real(series.times),
                    "y": columns.real(series.values),
                }
            )
    return [{"title": title, "series": series} for title, series in charts.items()]


def _series_of(track: Track, times: Sequence[float]) -> Iterator[Series]:
    """Yield what is drawn of a track beside its floor."""
    steps = [times[end] for end in track.ends]
    metrics = track.metrics
    if "rewards" in metrics:
        rewards = [0.0 if math.isnan(reward) else reward for reward in metrics["rewards"]]
        title = "Reward"
        yield Series(title, "each step", "bars", "battery", steps, rewards)
        yield Series(title, "so far", "line", INK, steps, list(accumulate(rewards)))
    for tile, name, words in (
        (PICKUP, "dist_pickup", "to pickup"), (DROPOFF, "dist_dropoff", "to dropoff"),
    ):  # fmt: skip
        if name in metrics:
            yield Series("Distance (cells)", words, "line", tile, steps, metrics[name])
    if track.is_continuous and track.shift is None:
        speeds = [frame.speed for frame in track.frames]
        yield Series("Speed (m/s)", "speed", "line", "battery", times, speeds)
    if any(frame.energy for frame in track.frames) and track.shift is None:
        used = [frame.energy for frame in track.frames]
        yield Series("Energy used (J)", "energy", "line", INK, times, used)
    if track.shift is not None:
        yield from _series_of_shift(track, steps)


def _series_of_shift(track: Track, steps: Sequence[float]) -> Iterator[Series]:
    shift = track.shift
    assert shift is not None, "only tracks of fleets have one"
    title = "Orders"
    yield Series(title, "released", "thin", INK, steps, shift.released)
    yield Series(title, "delivered", "steps", INK, steps, shift.delivered)
    title = "Lateness of deliveries (steps)"
    for name, color, is_late in (("on time", "battery", False), ("late", WARNING, True)):
        found = [(step, by) for step, by in shift.lateness if (by > 0) == is_late]
        ends = [steps[step] for step, _ in found]
        yield Series(title, name, "dots", color, ends, [by for _, by in found])
    title = "Battery (%)"
    yield Series(title, "mean", "line", "battery", steps, [100 * share for share in shift.battery])
    yield Series(title, "lowest", "thin", WARNING, steps, [100 * share for share in shift.lowest])
    used = [joules / 1000 for joules in shift.joules]
    yield Series("Energy used (kJ)", "energy", "line", INK, steps, used)
