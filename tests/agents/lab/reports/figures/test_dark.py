"""Figures that are dark where dark colours are preferred."""

import re
from io import BytesIO

import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.typing import ColorType

from agents.lab.reports.figures.dark import DARK, themed_svg
from agents.lab.reports.figures.modes import MODE_COLORS, ink_on
from warehouse_core.render.palette import COLORS, INK, PAPER
from warehouse_core.render.palette import SERIES as LINES
from warehouse_core.viz.axes.heat_map import HEAT, ink_of_heat
from warehouse_core.viz.figure import save_svg

STYLE = re.compile(r"<style>@media \(prefers-color-scheme:dark\)\{(.*?)\}</style>")


def luminance(color: str) -> float:
    """Return the relative luminance of WCAG 2.2."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in to_rgb(color)
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: ColorType, other: ColorType, *, dark: bool) -> float:
    """Return the contrast of two colours of a figure on a light page or on a dark one."""
    shown = [
        DARK.get(to_hex(each), to_hex(each)) if dark else to_hex(each) for each in (one, other)
    ]
    low, high = sorted(map(luminance, shown))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_what_is_drawn_can_be_seen_on_both_pages(dark: bool) -> None:
    assert contrast(INK, PAPER, dark=dark) > 12
    assert contrast(COLORS["#"], COLORS["."], dark=dark) > 2.5
    for color in (*LINES, *MODE_COLORS.values()):
        assert contrast(color, PAPER, dark=dark) > (2.5 if dark else 1.5), color
    for color in MODE_COLORS.values():
        assert contrast(ink_on(color), color, dark=dark) > 4.5, color
    for level in range(HEAT.N):
        share = level / (HEAT.N - 1)
        assert contrast(ink_of_heat(share), HEAT(share), dark=dark) > 3, level


def test_colours_of_a_chart_differ_on_a_dark_page() -> None:
    for colors in (LINES, [to_hex(HEAT(level)) for level in range(HEAT.N)]):
        assert len({DARK.get(color, color) for color in colors}) == len(colors)


def test_the_style_replaces_the_colours_that_are_used_and_nothing_else_changes() -> None:
    figure = Figure(figsize=(1, 1), facecolor=PAPER)
    figure.text(0.1, 0.1, "a", color=INK)
    figure.text(0.1, 0.5, "b", color="#d55e00")
    file = BytesIO()
    save_svg(figure, file)
    svg = themed_svg(figure).decode()
    assert STYLE.sub("", svg) == file.getvalue().decode()
    [rules] = STYLE.findall(svg)
    ink, paper = to_hex(INK), to_hex(PAPER)
    assert rules == (
        f'[style*="fill: {ink}"]{{fill:{DARK[ink]}!important}}'
        f'[style*="fill: {paper}"]{{fill:{DARK[paper]}!important}}'
    )
