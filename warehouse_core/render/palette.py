"""The colours of all pictures and pages. No information is conveyed by colour alone.

All colours are defined in ``palette.json``, which the player of pages reads too. It has the colours
of light pages, of dark pages and of both, the colours of lines in charts, and the colours of counts
on maps, from the lowest to the highest. Pictures use the colours of light pages.

Source of the colours of walls, floor, pickups, dropoffs and robots: the chapter's exercise.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
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
"""Red, green and blue, each from 0 to 1."""

FILES = files("warehouse_core.render")
"""Data of this folder, which may be in a ZIP file."""

PALETTE: dict[str, Any] = json.loads((FILES / "palette.json").read_text(encoding="utf-8"))
"""Colours as ``#rrggbb``: by name in ``light``, ``dark`` and ``both``, and as lists in ``series``
and ``heat``."""

LOOK: dict[str, Any] = json.loads((FILES / "tiles.json").read_text(encoding="utf-8"))
"""Labels and geometry of tiles, robots and items, by name, for all pictures and pages.

Lengths are in cells. The corners of ``shapes``, and of ``drives``, the parts below a chassis, are
relative to the centre of a cell or of a body that heads east. ``textures`` has the polygons of a
tile by their colour, relative to its top left corner. ``signs`` has the looks of signs in legends;
see ``look_of``. Font sizes are ``letter`` and ``name``, which is divided by the number of digits.
``lines`` has line widths; the width of ``letter`` is a share of the font size. Fleets of more than
``few`` robots show a battery only if its level is below the share ``low``.
"""


@cache
def color_named(name: str) -> Color:
    """Return a colour of light pages by its name in the palette.

    Raises:
        KeyError: the palette has no such name.
    """
    return rgb((PALETTE["both"] | PALETTE["light"])[name])


def rgb(text: str) -> Color:
    """Return the colour with the code ``#rrggbb``, each part with as few digits as possible."""
    red, green, blue = (_shortest(int(text[place : place + 2], 16)) for place in (1, 3, 5))
    return red, green, blue


def _shortest(byte: int) -> float:
    """Return the shortest decimal that rounds to a byte, such as the chapter's 0.95 for 242."""
    shares = (round(byte / 255, digits) for digits in (2, 3))
    return next(share for share in shares if round(255 * share) == byte)


def hex_color(color: Color) -> str:
    """Return the code ``#rrggbb`` of a colour."""
    return "#" + "".join(f"{round(255 * part):02x}" for part in color)


def style_rules() -> str:
    """Return the palette as custom properties of CSS, which follow the reader's colour scheme."""
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
"""Colours of tiles, robots and people. The colour of chargers has a contrast ratio of at least 3
with the floor, with walls and with ink."""

PAPER: Color = color_named("paper")
INK: Color = color_named("ink")
FAINT: Color = color_named("rule")
BATTERY: Color = color_named("battery")
WARNING: Color = color_named("warning")
HIT: Color = color_named("hit")

STRANDED: Color = color_named("stranded")
"""Colour of a robot of a fleet with an empty battery."""

ITEM: Color = color_named("item")
"""Colour of an item, a box whose edge of ink separates it from any background."""

ORDERS: list[str] = LOOK["orders"]
"""Names of the colours of an order by its age: one for each third of its time until due, and one
for late."""

ORDER_COLORS: tuple[Color, ...] = tuple(map(color_named, ORDERS))

LATE = len(ORDERS) - 1
"""Age of an order that is late."""

SHELF, BOARD = color_named("shelf"), color_named("board")
"""Colours of shelves, which are the walls inside the border, and of their boards."""

ICE, ICE_GLEAM, ICE_WAVE = (color_named(name) for name in ("ice", "gleam", "wave"))
"""Colours of slippery floor, and of the gleam and the waves on it."""

SERIES: tuple[str, ...] = tuple(PALETTE["series"]["light"])
"""Colours of lines in charts, ``#rrggbb``."""


def blend(color: Color, other: Color, share: float) -> Color:
    """Return ``color`` with a ``share`` of ``other`` mixed in."""
    mixed = [(1 - share) * a + share * b for a, b in zip(color, other, strict=True)]
    return mixed[0], mixed[1], mixed[2]


SKID = blend(ICE, INK, 0.5)
"""Colour of skid marks on slippery floor."""

SHADOW = int(PALETTE["light"]["shadow"][7:], 16) / 255
"""Share of ink in the colours of cells outside a robot's view."""

_SHADED = tuple(
    blend(color, INK, SHADOW)
    for color in (*(COLORS[tile] for tile in (EMPTY, WALL, PICKUP, DROPOFF, CHARGER)), SHELF, BOARD)
)

TRAIL_COLORS = {
    False: blend(COLORS[ROBOT_EMPTY], COLORS[EMPTY], 0.25),
    True: blend(COLORS[ROBOT_LOADED], COLORS[EMPTY], 0.25),
}

FADES = 5
"""Number of shades of a trail, which depend on its age."""

VISITED: tuple[Color, ...] = tuple(
    blend(COLORS[EMPTY], color_named("visited"), share) for share in (0.12, 0.3, 0.5)
)
"""Colours of cells that a robot has visited two or three, four or five, and more times."""


def faded_trail(loaded: bool, age: float) -> Color:
    """Return the colour of a trail; ``age`` is at least 0 and below 1."""
    return blend(TRAIL_COLORS[loaded], COLORS[EMPTY], 0.8 * int(age * FADES) / FADES)


_TINTS = (
    ITEM, SHELF, BOARD, *_SHADED, ICE, ICE_GLEAM, ICE_WAVE, SKID, *VISITED,
    *(faded_trail(loaded, age / FADES) for loaded in (False, True) for age in range(1, FADES)),
)  # fmt: skip
"""Colours for which files have no blends, so their edges are less smooth."""

_NAMES = (
    "paper", "ink", "rule", "battery", "warning", "pale-warning", "hit", "velocity", "force",
    "brake", "stranded",
)  # fmt: skip
_OWN_COLORS = (
    *map(color_named, _NAMES), *ORDER_COLORS, *COLORS.values(), *TRAIL_COLORS.values()
)  # fmt: skip
_GROUNDS = (PAPER, INK, COLORS[EMPTY])
MAX_COLORS = 255
"""Most colours of a file. Its 256th colour stands for an unchanged pixel."""

_NEAR = 0.03
"""Distance up to which Pillow treats colours as equal."""


@cache
def indexed_palette() -> list[int]:
    """Return the palette of files as bytes: the colours of replays, and blends for smooth edges."""
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
