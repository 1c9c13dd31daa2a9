"""The colours of every picture and page. No information is in a colour alone.

The file ``palette.json`` has all of them, and the player of pages reads it too. It lists the
colours of a light page, of a dark page and of both, the colours of lines in charts, and the
colours of counts on maps, lowest first. Pictures have the colours of a light page.

Source of the colours of walls, floor, pickups, dropoffs and robots: the chapter's exercise.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

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

PALETTE: dict[str, Any] = json.loads(
    Path(__file__).with_name("palette.json").read_text(encoding="utf-8")
)
"""Colours by name as ``#rrggbb``: ``light``, ``dark``, ``both``; lists: ``series``, ``heat``."""

LOOK: dict[str, Any] = json.loads(
    Path(__file__).with_name("tiles.json").read_text(encoding="utf-8")
)
"""Words and geometry of tiles, robots and what is on them, by name, for every picture and page.

Lengths are in cells. The corners of ``shapes`` are around the middle of a cell or of a body, which
heads east. ``letter`` and ``name`` are sizes of fonts, ``name`` divided by the number of digits;
``lines`` are widths, of ``letter`` as a share of its size. Fleets of more than ``few`` robots show
only batteries below a share ``low`` of a full one.
"""


def color_named(name: str) -> Color:
    """Return a colour of a light page by its name in the palette.

    Raises:
        KeyError: the palette has no such name.
    """
    return rgb((PALETTE["both"] | PALETTE["light"])[name])


def rgb(text: str) -> Color:
    """Return the colour that is written as ``#rrggbb``, each part with the fewest digits."""
    red, green, blue = (_shortest(int(text[place : place + 2], 16)) for place in (1, 3, 5))
    return red, green, blue


def _shortest(byte: int) -> float:
    """Return the shortest decimal that stands for a byte: 0.95 for 242, as the chapter writes."""
    shares = (round(byte / 255, digits) for digits in (2, 3))
    return next(share for share in shares if round(255 * share) == byte)


def hex_color(color: Color) -> str:
    """Return a colour as ``#rrggbb``."""
    return "#" + "".join(f"{round(255 * part):02x}" for part in color)


def style_rules() -> str:
    """Return the palette as custom properties of CSS, dark where the reader prefers that."""
    light, dark = (
        "".join(f"--{name}:{color};" for name, color in colors.items())
        for colors in (PALETTE["light"] | PALETTE["both"], PALETTE["dark"])
    )
    return f":root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}"


COLORS: dict[str, Color] = {
    WALL: color_named("wall"),
    EMPTY: color_named("floor"),
    PICKUP: color_named("pickup"),
    DROPOFF: color_named("dropoff"),
    ROBOT_EMPTY: color_named("robot"),
    ROBOT_LOADED: color_named("loaded"),
    CHARGER: color_named("charger"),
    OTHER_EMPTY: color_named("other"),
    OTHER_LOADED: color_named("other-loaded"),
    PERSON: color_named("person"),
}
"""A charger has a contrast of at least 3 to the floor, to walls and to ink."""

PAPER: Color = color_named("paper")
INK: Color = color_named("ink")
FAINT: Color = color_named("rule")
BATTERY: Color = color_named("battery")
WARNING: Color = color_named("warning")
PALE_WARNING: Color = color_named("pale-warning")
HIT: Color = color_named("hit")

STRANDED: Color = color_named("stranded")
"""Colour of a robot of a fleet whose battery is empty."""

ITEM: Color = color_named("item")
"""Colour of an item, a box with an edge of ink, which separates it from every ground."""

ORDER_COLORS: tuple[Color, ...] = (
    ITEM, *(color_named(f"order-{age}") for age in ("older", "nearly-due", "late")),
)  # fmt: skip
"""Colours of an order by its age: in the three thirds of its time, and late."""

UNKNOWN: Color = color_named("unseen")
"""Colour of a cell that a robot has not seen; the palette of files has a close enough match."""

UNKNOWN_STRIPE: Color = color_named("stripe")
"""Colour of the stripe in a cell that a robot has not seen."""

SHELF, BOARD = color_named("shelf"), color_named("board")
"""Colours of walls inside the border, and of the boards on them."""

ICE, ICE_WAVE = color_named("ice"), color_named("wave")
"""Colours of slippery floor and of the waves on it."""

SERIES: tuple[str, ...] = tuple(PALETTE["series"]["light"])
"""Colours of lines in charts, ``#rrggbb``."""


def blend(color: Color, other: Color, share: float) -> Color:
    """Return ``color`` with a ``share`` of ``other`` mixed in."""
    mixed = [(1 - share) * a + share * b for a, b in zip(color, other, strict=True)]
    return mixed[0], mixed[1], mixed[2]


SHADOW = int(PALETTE["light"]["shadow"][7:], 16) / 255
"""Share of ink in the colours of what a robot does not see."""

_SHADED = tuple(
    blend(color, INK, SHADOW)
    for color in (*(COLORS[tile] for tile in (EMPTY, WALL, PICKUP, DROPOFF, CHARGER)), SHELF, BOARD)
)

TRAIL_COLORS = {
    False: blend(COLORS[ROBOT_EMPTY], COLORS[EMPTY], 0.25),
    True: blend(COLORS[ROBOT_LOADED], COLORS[EMPTY], 0.25),
}

FADES = 5
"""Shades of a trail by its age."""

VISITED: tuple[Color, ...] = tuple(
    blend(COLORS[EMPTY], color_named("visited"), share) for share in (0.12, 0.3, 0.5)
)
"""Colours of floor that a robot has been to twice, three or four times, and more often."""


def faded_trail(loaded: bool, age: float) -> Color:
    """Return the colour of a trail by its age, from 0 to below 1."""
    return blend(TRAIL_COLORS[loaded], COLORS[EMPTY], 0.8 * int(age * FADES) / FADES)


_TINTS = (
    ITEM, SHELF, BOARD, *_SHADED, ICE, ICE_WAVE, *VISITED,
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
