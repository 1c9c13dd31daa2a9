import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from helpers.colors import EYES, contrast, seen_contrast, seen_distance
from PIL import Image

import warehouse_core
from warehouse_core.render import palette
from warehouse_core.render.palette import COLORS, TRAIL_COLORS, blend, indexed_palette

CHAPTER = {
    "#": (0.1, 0.1, 0.1),
    ".": (0.95, 0.95, 0.95),
    "P": (0.2, 0.6, 1.0),
    "D": (0.2, 0.8, 0.3),
    "R": (0.9, 0.2, 0.2),
    "r": (0.95, 0.6, 0.2),
}


def test_the_six_colours_are_the_chapters() -> None:
    assert dict(list(COLORS.items())[:6]) == CHAPTER


GROUNDS = {
    **{sign: COLORS[sign] for sign in ".PDC"},
    "floor that is not seen": blend(COLORS["."], palette.INK, palette.SHADOW),
    "slippery floor": palette.ICE,
    **{f"visited {n}": color for n, color in enumerate(palette.VISITED)},
}


@pytest.mark.parametrize("eyes", EYES)
def test_robots_and_items_are_told_from_what_is_under_them_by_every_eye(eyes: str) -> None:
    """Their outline is of ink, which has the contrast that their fixed colours do not have."""
    for name, ground in GROUNDS.items():
        assert seen_contrast(eyes, palette.INK, ground) >= 3, f"an outline on {name}"
    for name, color in (("item", palette.ITEM), ("loaded robot", COLORS["r"])):
        assert seen_contrast(eyes, palette.INK, color) >= 3, f"an outline around {name}"
    assert seen_contrast(eyes, palette.PAPER, COLORS["R"]) >= 3, "the letter of an empty robot"


@pytest.mark.parametrize("eyes", EYES)
def test_walls_and_shelves_are_told_from_floor_and_from_each_other_by_every_eye(eyes: str) -> None:
    for name, ground in GROUNDS.items():
        if name not in "PDC":
            assert seen_contrast(eyes, COLORS["#"], ground) >= 3, name
    assert seen_contrast(eyes, palette.SHELF, COLORS["."]) >= 3
    assert seen_contrast(eyes, palette.ICE_WAVE, palette.ICE) >= 3


FLOOR = ["floor", "shelf", "wall", "unseen", "pickup", "dropoff", "charger", "robot", "loaded",
         "person", "ice"]  # fmt: skip
SIDE_BY_SIDE = {
    "floor": FLOOR,
    "window": [*(name for name in FLOOR if name != "ice"), "other", "other-loaded"],
    "fleet": [*(name for name in FLOOR if name not in ("unseen", "ice")), "stranded", "item",
              "order-older", "order-nearly-due", "order-late"],
    "ends of episodes": ["delivered", "unreachable", "stalled", "ineffective", "oscillation",
                         "wandering", "out-of-battery", "out-of-time", "unfinished"],
}  # fmt: skip
CHAPTERS = {"dropoff", "robot", "loaded"}
"""Colours that the chapter fixes: for green-blind eyes the first is 14.8 from the second, for
red-blind ones 9.0 from the third. One is a square with a D, the others are discs with an outline.
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("place", [*SIDE_BY_SIDE, "series"])
def test_colours_that_stand_side_by_side_differ_for_every_eye(place: str, scheme: str) -> None:
    known = palette.PALETTE["both"] | palette.PALETTE[scheme]
    if place == "series":
        known = {str(n): color for n, color in enumerate(palette.PALETTE["series"][scheme])}
    names = SIDE_BY_SIDE.get(place, [*known])
    colors = {name: palette.rgb(known[name]) for name in names}
    near = {
        (eyes, one, other): round(seen_distance(eyes, colors[one], colors[other]), 1)
        for eyes in EYES
        for one, other in combinations(colors, 2)
        if not {one, other} <= CHAPTERS and seen_distance(eyes, colors[one], colors[other]) < 15
    }
    assert not near


def test_a_charger_is_seen_on_the_floor_and_beside_walls_and_its_letter_on_it() -> None:
    for other in (COLORS["."], COLORS["#"], palette.INK):
        assert contrast(COLORS["C"], other) >= 3


def test_numbers_are_read_on_robots_and_orders() -> None:
    for color in (COLORS["R"], palette.STRANDED):
        assert contrast(color, palette.PAPER) >= 4
    assert contrast(COLORS["r"], palette.INK) >= 4
    *ages, late = palette.ORDER_COLORS
    assert min(contrast(age, palette.INK) for age in ages) >= 4
    assert contrast(late, palette.PAPER) >= 4
    shades = [contrast(age, palette.PAPER) for age in palette.ORDER_COLORS]
    assert shades == sorted(shades), "an order darkens with its age"
    assert min(contrast(age, late) for age in ages) >= 3


def test_the_indexed_palette_fits_into_a_gif() -> None:
    values = indexed_palette()
    assert len(values) % 3 == 0
    assert 3 * len(COLORS) < len(values) <= 3 * 255
    assert all(0 <= value <= 255 for value in values)


def test_colours_of_the_replay_are_exact_in_256_colours() -> None:
    named = {name: color for name, color in vars(palette).items() if name.isupper()}
    own = [color for color in named.values() if np.shape(color) == (3,)]
    own += [*COLORS.values(), *TRAIL_COLORS.values(), *palette.VISITED, *palette.ORDER_COLORS]
    own += [palette.faded_trail(loaded, 0.3) for loaded in (False, True)]
    assert {palette.PAPER, palette.SHELF, palette.ICE_WAVE} < {*own}
    template = Image.new("P", (1, 1))
    template.putpalette(indexed_palette())
    for color in own:
        exact = tuple(round(255 * part) for part in color)
        indexed = Image.new("RGB", (8, 8), exact).quantize(
            palette=template, dither=Image.Dither.NONE
        )
        assert indexed.convert("RGB").getpixel((3, 3)) == exact


PAINTERS = [
    *(f"render/{name}.py" for name in ("atlas", "painter")),
    *(f"viz/{name}.py" for name in ("view", "svg/bodies", "svg/floor")),
    *(f"viz/player/{name}.js" for name in ("bodies", "floor", "paths")),
]


@pytest.mark.parametrize("painter", PAINTERS)
def test_no_painter_writes_a_number_that_is_in_the_table_of_tiles(painter: str) -> None:
    """Numbers that also stand for something else, such as a half, are left out."""
    code = (Path(warehouse_core.__file__).parent / painter).read_text(encoding="utf-8")
    look = palette.LOOK
    numbers = {look["robot"]["radius"], look["robot"]["letter"], look["shapes"]["nose"][0][0]}
    numbers |= {round(100 * number) for number in numbers}
    written = {float(number) for number in re.findall(r"(?<![\w.])\d*\.?\d+(?![\w.])", code)}
    assert "LOOK" in code or painter in ("render/painter.py", "viz/player/paths.js")
    assert not written & numbers
