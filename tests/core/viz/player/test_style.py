import re

import pytest
from helpers.colors import EYES, seen_contrast
from matplotlib.colors import to_rgb

from warehouse_core.render.palette import COLORS, ORDER_COLORS, STRANDED
from warehouse_core.viz.player.page import style

LEAST = 3.0


def theme(scheme: str) -> dict[str, tuple[float, float, float]]:
    """Return the colours of the page by name, without those that are transparent."""
    light, dark = re.findall(r":root\{([^}]*)\}", style())
    text = light if scheme == "light" else light + dark
    return {name: to_rgb(color) for name, color in re.findall(r"--([\w-]+):(#\w{6});", text)}


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_what_must_be_told_apart_has_contrast(scheme: str, eyes: str) -> None:
    colors = theme(scheme)

    def apart(one: tuple[float, float, float], other: tuple[float, float, float]) -> bool:
        return seen_contrast(eyes, one, other) >= LEAST

    for name in ("wall", "shelf", "unseen", "rim", "ink", "accent"):
        assert apart(colors[name], colors["floor"]), name
    for name in ("ink", "quiet", "accent", "warning"):
        assert apart(colors[name], colors["paper"]), name
    # Letters and numbers on robots, people and stations; items have dark and light edges.
    for letters, signs in (("light", "RH"), ("dark", "rPDC")):
        assert all(apart(COLORS[sign], colors[letters]) for sign in signs), signs
    assert apart(STRANDED, colors["light"])
    for color in ORDER_COLORS:
        assert apart(color, colors["dark"]) or apart(color, colors["light"])
