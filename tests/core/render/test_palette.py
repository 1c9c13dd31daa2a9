import pytest
from PIL import Image

from warehouse_core.render import palette
from warehouse_core.render.palette import COLORS, TRAIL_COLORS, TRAIL_STYLES, blend, indexed_palette

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


def contrast(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Return the contrast of two colours, 1 to 21, by WCAG 2."""

    def luminance(color: tuple[float, float, float]) -> float:
        red, green, blue = (
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in color
        )
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    darker, lighter = sorted((luminance(one), luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


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


def test_a_blend_is_between_its_colours() -> None:
    black, white = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    assert blend(black, white, 0) == black
    assert blend(black, white, 1) == white
    assert blend((0.0, 0.5, 1.0), white, 0.5) == (0.5, 0.75, 1.0)


def test_the_indexed_palette_fits_into_a_gif() -> None:
    values = indexed_palette()
    assert len(values) % 3 == 0
    assert 3 * len(COLORS) < len(values) <= 3 * 256
    assert all(0 <= value <= 255 for value in values)


def test_the_entries_of_the_indexed_palette_are_different() -> None:
    values = indexed_palette()
    entries = list(zip(values[::3], values[1::3], values[2::3], strict=True))
    assert len(set(entries)) == len(entries)


@pytest.mark.parametrize(
    "color",
    [
        *COLORS.values(),
        *TRAIL_COLORS.values(),
        palette.PAPER,
        palette.INK,
        palette.FAINT,
        palette.BATTERY,
        palette.WARNING,
        palette.PALE_WARNING,
        palette.HIT,
    ],
)
def test_colours_of_the_replay_are_exact_in_256_colours(
    color: tuple[float, float, float],
) -> None:
    exact = tuple(round(255 * part) for part in color)
    template = Image.new("P", (1, 1))
    template.putpalette(indexed_palette())
    image = Image.new("RGB", (8, 8), exact)
    indexed = image.quantize(palette=template, dither=Image.Dither.NONE)
    assert indexed.convert("RGB").getpixel((3, 3)) == exact


def test_trails_differ_by_more_than_their_colour() -> None:
    assert TRAIL_STYLES[False] != TRAIL_STYLES[True]
