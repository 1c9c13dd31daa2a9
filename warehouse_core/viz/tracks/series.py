"""What charts draw beside the floor of a track, in a page as in a window."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

from warehouse_core.viz.tracks.track import Track

SeriesKind = Literal["line", "thin", "steps", "bars", "dots"]

INK, WARNING = "ink", "warning"
"""Names of colours of the palette."""


class Series(NamedTuple):
    """Numbers in a chart: its title, their name, how they are drawn, their times and themselves."""

    chart: str
    name: str
    kind: SeriesKind
    color: str
    times: Sequence[float]
    values: Sequence[float]


def series_of(track: Track, times: Sequence[float]) -> Iterator[Series]:
    """Yield what is drawn of a track beside its floor; ``times`` has an entry for each frame."""
    steps = [times[end] for end in track.ends]
    metrics = track.metrics
    if "rewards" in metrics:
        rewards, totals = track.rewards_until(track.steps)
        yield Series("Reward", "each step", "bars", "battery", steps, rewards)
        yield Series("Reward", "so far", "line", INK, steps, totals)
    for station in ("pickup", "dropoff"):
        if (name := f"dist_{station}") in metrics:
            title, words = "Distance (cells)", f"to {station}"
            yield Series(title, words, "line", station, steps, metrics[name])
    if track.counts_orders:
        yield from _series_of_orders(track, steps)
        return
    if track.is_continuous:
        speeds = [frame.speed for frame in track.frames]
        yield Series("Speed (m/s)", "speed", "line", "battery", times, speeds)
    used = [frame.energy for frame in track.frames]
    if any(used):
        yield Series("Energy used (J)", "energy", "line", INK, times, used)


def _series_of_orders(track: Track, steps: Sequence[float]) -> Iterator[Series]:
    metrics = track.metrics
    yield Series("Orders", "released", "thin", INK, steps, metrics["released"])
    yield Series("Orders", "delivered", "steps", INK, steps, metrics["delivered"])
    title = "Lateness (steps)"
    for name, color, is_late in (("on time", "battery", False), ("late", WARNING, True)):
        shown = [(step, by) for step, by in track.lateness if (by > 0) == is_late]
        ends = [steps[step] for step, _ in shown]
        yield Series(title, name, "dots", color, ends, [by for _, by in shown])
    mean, lowest = (
        [100 * share for share in metrics[name]] for name in ("battery_mean", "battery_lowest")
    )
    yield Series("Battery (%)", "mean", "line", "battery", steps, mean)
    yield Series("Battery (%)", "lowest", "thin", WARNING, steps, lowest)
    used = [joules / 1000 for joules in metrics["joules"]]
    yield Series("Energy used (kJ)", "energy", "line", INK, steps, used)
