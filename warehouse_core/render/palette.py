"""The colours of a replay and its legend. No information is in a colour alone.

Source of the six tile and robot colours: the chapter's exercise.
"""

from __future__ import annotations

from functools import cache
from typing import Literal

from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    EMPTY,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    WALL,
)

Color = tuple[float, float, float]
"""RGB, 0..1."""

COLORS: dict[str, Color] = {
    WALL: (0.1, 0.1, 0.1),
    EMPTY: (0.95, 0.95, 0.95),
    PICKUP: (0.2, 0.6, 1.0),
    DROPOFF: (0.2, 0.8, 0.3),
    ROBOT_EMPTY: (0.9, 0.2, 0.2),
    ROBOT_LOADED: (0.95, 0.6, 0.2),
}

FLEET_COLORS: dict[str, Color] = {
    CHARGER: (0.95, 0.85, 0.25),
    OTHER_EMPTY: (0.95, 0.7, 0.85),
    OTHER_LOADED: (0.5, 0.42, 0.2),
    PERSON: (0.3, 0.3, 0.75),
}

PAPER: Color = (1.0, 1.0, 1.0)
INK: Color = (0.12, 0.12, 0.15)
FAINT: Color = (0.82, 0.82, 0.84)
BATTERY: Color = (0.35, 0.45, 0.6)
WARNING: Color = COLORS[ROBOT_EMPTY]
PALE_WARNING: Color = (1.0, 0.85, 0.85)
HIT: Color = (1.0, 0.85, 0.1)

UNKNOWN: Color = (0.62, 0.62, 0.66)
"""Of a cell that a robot does not see; the palette of files has a close enough match."""

UNKNOWN_STRIPE: Color = (0.72, 0.72, 0.75)
"""Of the stripes in such a cell."""

LineStyle = Literal["-"] | tuple[float, tuple[float, ...]]

TRAIL_STYLES: dict[bool, LineStyle] = {False: "-", True: (0, (2.5, 1.5))}
"""Line style of the trail by whether the robot was loaded."""


def blend(color: Color, other: Color, share: float) -> Color:
    """Return ``color`` with a ``share`` of ``other`` mixed in."""
    mixed = [(1 - share) * a + share * b for a, b in zip(color, other, strict=True)]
    return mixed[0], mixed[1], mixed[2]


TRAIL_COLORS = {
    False: blend(COLORS[ROBOT_EMPTY], COLORS[EMPTY], 0.25),
    True: blend(COLORS[ROBOT_LOADED], COLORS[EMPTY], 0.25),
}

_OWN_COLORS = (
    PAPER, INK, FAINT, BATTERY, WARNING, PALE_WARNING, HIT,
    *COLORS.values(), *TRAIL_COLORS.values(),
)  # fmt: skip
_GROUNDS = (PAPER, INK, COLORS[EMPTY])
_NEAR = 0.03
"""Pillow treats colours this close as the same."""


@cache
def indexed_palette() -> list[int]:
    """Return bytes of R, G, B: the colours of a replay, and blends of them for smooth edges."""
    colors = list(dict.fromkeys(_OWN_COLORS))
    edges = [
        blend(color, ground, share)
        for color in colors
        for ground in _GROUNDS
        for share in (0.25, 0.5, 0.75)
    ]
    for edge in edges:
        if all(
            max(abs(a - b) for a, b in zip(edge, color, strict=True)) > _NEAR for color in colors
        ):
            colors.append(edge)
    return [round(255 * part) for color in colors[:256] for part in color]
