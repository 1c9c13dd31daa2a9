"""Figures as SVG that are dark on a dark page.

A figure has the colours of a light page, which every program can draw. A style sheet that is added
to the file replaces them where dark colours are preferred.
"""

from __future__ import annotations

import re
from io import BytesIO

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from warehouse_core.render.palette import COLORS, FAINT, INK, PAPER
from warehouse_core.viz.axes.heat_map import HEAT
from warehouse_core.viz.figure import save_svg
from warehouse_core.world.tiles import EMPTY, WALL

DARK_HEAT = mpl.colormaps["inferno"](np.linspace(0.27, 0.82, HEAT.N))
"""Colours of heat, the hottest the lightest; numbers are legible on these and on ``HEAT``."""

DARK = {
    to_hex(PAPER): "#17181c",
    to_hex(INK): "#e6e6ea",
    to_hex(FAINT): "#3a3b42",
    to_hex(COLORS[EMPTY]): "#2a2c33",
    to_hex(COLORS[WALL]): "#6d707b",
    "#0072b2": "#3f9be0",
    **{to_hex(HEAT(level)): to_hex(DARK_HEAT[level]) for level in range(HEAT.N)},
}
"""Colours of a dark page by the colours of a light one; others are the same on both."""

SVG_START = re.compile(rb"<svg [^>]*>")

USED = re.compile(rb"(fill|stroke): (#[0-9a-f]{6})")


def themed_svg(figure: Figure) -> bytes:
    """Return a figure as SVG that follows the reader's colour scheme."""
    file = BytesIO()
    save_svg(figure, file)
    svg = file.getvalue()
    used = sorted({(part.decode(), color.decode()) for part, color in USED.findall(svg)})
    rules = "".join(
        f'[style*="{part}: {color}"]{{{part}:{DARK[color]}!important}}'
        for part, color in used
        if color in DARK
    )
    style = f"<style>@media (prefers-color-scheme:dark){{{rules}}}</style>"
    return SVG_START.sub(lambda found: found[0] + style.encode(), svg, count=1)
