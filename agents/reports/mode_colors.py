"""The colours of the failure modes, the same in every chart of a report."""

from __future__ import annotations

from matplotlib.colors import to_rgb

from warehouse_core.episode import BATTERY_DEPLETED, DELIVERED, OUT_OF_TIME, UNFINISHED
from warehouse_core.failure_modes import OSCILLATION, STALLED, UNREACHABLE, WANDERING

MODE_COLORS = {
    DELIVERED: "#2a9d5c",
    UNREACHABLE: "#6b6b70",
    STALLED: "#8c4fa3",
    OSCILLATION: "#d1495b",
    WANDERING: "#edae49",
    BATTERY_DEPLETED: "#2e6fa7",
    OUT_OF_TIME: "#8ab6d6",
    UNFINISHED: "#c9c9ce",
}

LUMINANCE = (0.299, 0.587, 0.114)
"""Weights of R, G and B. Source: ITU-R BT.601."""


def ink_on(color: str) -> str:
    """Return black or white, whichever can be read on a colour."""
    light = sum(weight * part for weight, part in zip(LUMINANCE, to_rgb(color), strict=True))
    return "black" if light > 0.55 else "white"
