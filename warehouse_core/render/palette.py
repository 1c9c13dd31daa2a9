"""The colours of a replay and its legend. No information is in a colour alone.

Source of the first six colours of tiles and robots: the chapter's exercise.
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
    CHARGER: (0.65, 0.4, 0.95),
    OTHER_EMPTY: (0.42, 0.15, 0.4),
    OTHER_LOADED: (0.6, 0.55, 0.15),
    PERSON: (0.15, 0.35, 0.5),
}
"""A charger has a contrast of at least 3 to the floor, to walls and to ink."""

PAPER: Color = (1.0, 1.0, 1.0)
INK: Color = (0.12, 0.12, 0.15)
FAINT: Color = (0.82, 0.82, 0.84)
BATTERY: Color = (0.35, 0.45, 0.6)
WARNING: Color = COLORS[ROBOT_EMPTY]
PALE_WARNING: Color = (1.0, 0.85, 0.85)
HIT: Color = (1.0, 0.85, 0.1)

STRANDED: Color = (0.38, 0.38, 0.4)
"""Colour of a robot of a fleet whose battery is empty."""

ORDER_COLORS: tuple[Color, ...] = (
    (1.0, 0.96, 0.75), (1.0, 0.76, 0.25), (0.9, 0.47, 0.08), (0.52, 0.0, 0.14),
)  # fmt: skip
"""Colours of an order by its age: in the three thirds of its time, and late."""

UNKNOWN: Color = (0.62, 0.62, 0.66)
"""Colour of a cell that a robot does not see; the palette of files has a close enough match."""

UNKNOWN_STRIPE: Color = (0.72, 0.72, 0.75)
"""Colour of the stripes in a cell that a robot does not see."""

ITEM: Color = (1.0, 0.92, 0.7)
"""Colour of an item, a box with an edge of ink, which separates it from every ground."""

SHELF: Color = (0.46, 0.46, 0.48)
"""Colour of walls inside the border, between boards of the colour of walls."""

SEEN: Color = (1.0, 0.975, 0.82)
"""Colour of the floor that a robot sees."""

ICE, ICE_WAVE = (0.8, 0.92, 1.0), (0.1, 0.45, 0.7)
"""Colours of slippery floor and of the waves on it."""

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

FADES = 5
"""Shades of a trail by its age."""

VISITED: tuple[Color, ...] = tuple(
    blend(COLORS[EMPTY], COLORS[ROBOT_EMPTY], share) for share in (0.12, 0.22, 0.34)
)
"""Colours of floor that a robot has been to twice, three or four times, and more often."""


def faded_trail(loaded: bool, age: float) -> Color:
    """Return the colour of a trail by its age, from 0 to below 1."""
    return blend(TRAIL_COLORS[loaded], COLORS[EMPTY], 0.8 * int(age * FADES) / FADES)


_TINTS = (
    ITEM, SHELF, SEEN, ICE, ICE_WAVE, *VISITED,
    *(faded_trail(loaded, age / FADES) for loaded in (False, True) for age in range(1, FADES)),
)  # fmt: skip
"""Colours without smooth edges of their own in files."""

_OWN_COLORS = (
    PAPER, INK, FAINT, BATTERY, WARNING, PALE_WARNING, HIT, STRANDED, *ORDER_COLORS,
    *COLORS.values(), *TRAIL_COLORS.values(),
)  # fmt: skip
_GROUNDS = (PAPER, INK, COLORS[EMPTY])
MAX_COLORS = 255
"""Limit on the colours of a file; its 256th colour means that nothing has changed."""

_NEAR = 0.03
"""Pillow treats colours this close as the same."""


@cache
def indexed_palette() -> list[int]:
    """Return bytes of R, G, B: the colours of a replay, and blends of them for smooth edges."""
    colors = list(dict.fromkeys((*_OWN_COLORS, *_TINTS)))
    edges = [
        blend(color, ground, share)
        for color in _OWN_COLORS
        for ground in _GROUNDS
        for share in (0.25, 0.5, 0.75)
    ]
    for edge in edges:
        if all(
            max(abs(a - b) for a, b in zip(edge, color, strict=True)) > _NEAR for color in colors
        ):
            colors.append(edge)
    return [round(255 * part) for color in colors[:MAX_COLORS] for part in color]
