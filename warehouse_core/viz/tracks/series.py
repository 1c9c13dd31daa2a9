"""The data series of the charts next to a floor, the same on a page and in a window."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

from warehouse_core.viz.tracks.track import Track

SeriesKind = Literal["line", "thin", "steps", "bars", "dots"]

INK, WARNING = "ink", "warning"
"""Names of colours of the palette."""


class Series(NamedTuple):
    """One series of a chart.

    Attributes:
        chart: title of the chart.
        name: name of the series in the chart.
        kind: style in which the series is drawn.
        color: name of its colour in the palette.
        times: time of each value.
        values: values, NaN where nothing is drawn.
        steps: word for values that count steps, such as ``"late"`` for "3 steps late"; empty for
            other values.
    """

    chart: str
    name: str
    kind: SeriesKind
    color: str
    times: Sequence[float]
    values: Sequence[float]
    steps: str = ""


def series_of(track: Track, times: Sequence[float]) -> Iterator[Series]:
    """Yield the series of the charts of a track; ``times`` has the time of each frame."""
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
    for name, word, color in (("on time", "early", "battery"), ("late", "late", WARNING)):
        shown = [(step, by) for step, by in track.lateness if (by > 0) == (name == "late")]
        ends = [steps[step] for step, _ in shown]
        yield Series(title, name, "dots", color, ends, [by for _, by in shown], word)
    mean, lowest = (
        [100 * share for share in metrics[name]] for name in ("battery_mean", "battery_lowest")
    )
    yield Series("Battery (%)", "mean", "line", "battery", steps, mean)
    yield Series("Battery (%)", "lowest", "thin", WARNING, steps, lowest)
    used = [joules / 1000 for joules in metrics["joules"]]
    yield Series("Energy used (kJ)", "energy", "line", INK, steps, used)
