"""The data series of the charts next to a floor, the same on a page and in a window."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Literal, NamedTuple

import numpy as np

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
            other values. The axis of such values has "3 late" above "on time", and
            "3 early" below it.
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
        rewards = [0.0 if math.isnan(reward) else reward for reward in metrics["rewards"]]
        yield Series("Reward", "each step", "bars", "battery", steps, rewards)
        yield Series("Reward", "so far", "line", INK, steps, [*accumulate(rewards)])
    for station in ("pickup", "dropoff"):
        if (name := f"dist_{station}") in metrics:
            title, words = "Distance (cells)", f"to {station}"
            yield Series(title, words, "line", station, steps, metrics[name])
    if track.counts_orders:
        yield from _series_of_orders(track, steps)
        return
    if track.readings:
        # The frames are too far apart to show the highest speeds and forces.
        measured, speeds, forces, energy = track.readings
        moments = np.interp(measured, [frame.clock for frame in track.frames], times).tolist()
        yield Series("Speed (m/s)", "speed", "line", "velocity", moments, speeds)
        yield Series("Motor force (N)", "along the heading", "line", "force", moments, forces)
        yield Series("Energy used (J)", "energy", "line", INK, moments, energy)
    elif track.is_measured:
        used = [track.frames[end].energy for end in track.ends]
        yield Series("Energy used (J)", "energy", "line", INK, steps, used)


def _series_of_orders(track: Track, steps: Sequence[float]) -> Iterator[Series]:
    metrics = track.metrics
    yield Series("Orders", "released", "thin", INK, steps, metrics["released"])
    yield Series("Orders", "delivered", "steps", INK, steps, metrics["delivered"])
    title = "Deliveries (steps)"
    for name, word, color in (("on time", "early", "battery"), ("late", "late", WARNING)):
        shown = [(step, by) for step, by in track.lateness if (by > 0) == (name == "late")]
        ends = [steps[step] for step, _ in shown]
        yield Series(title, name, "dots", color, ends, [by for _, by in shown], word)
    mean, lowest = (
        [100 * share for share in metrics[name]] for name in ("battery_mean", "battery_lowest")
    )
    yield Series("Battery (%)", "mean", "line", "battery", steps, mean)
    yield Series("Battery (%)", "lowest", "thin", WARNING, steps, lowest)
    if "joules" in metrics:
        used = [joules / 1000 for joules in metrics["joules"]]
        yield Series("Energy used (kJ)", "energy", "line", INK, steps, used)
