"""Figures as SVG that are dark on a dark page.

A figure has the colours of a light page, which every program can draw. A style sheet that is added
to the file replaces them where dark colours are preferred.
"""

from __future__ import annotations

import re
from io import BytesIO

from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from warehouse_core.render.palette import PALETTE
from warehouse_core.viz.axes.heat_map import DARK_HEAT, HEAT
from warehouse_core.viz.figure import save_svg

DARK = {
    **{light: PALETTE["dark"][name] for name, light in PALETTE["light"].items() if name != "rim"},
    **dict(zip(PALETTE["series"]["light"], PALETTE["series"]["dark"], strict=True)),
    **{to_hex(HEAT(level)): to_hex(DARK_HEAT(level)) for level in range(HEAT.N)},
}
"""Colours of a dark page by the colours of a light one; others are the same on both.

Rims are left out: no figure has them, and letters that stay dark have their colour.
"""

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
