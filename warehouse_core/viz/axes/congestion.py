"""Heat maps, side by side, that show where the robots of several fleets were held up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from warehouse_core.records.episode import FleetEpisode
from warehouse_core.records.held_up import held_up
from warehouse_core.render.palette import INK, PAPER
from warehouse_core.viz.axes.heat_map import CellCounts, draw_heat
from warehouse_core.viz.axes.look import POINTS, box_in

PANEL, MAX_CELL, SPACE = 6.2, 0.4, 0.55
"""Width of a panel, largest width of a cell, and space between panels, in inches."""

HEAD, PANEL_HEAD, FOOT, BAR = 0.95, 0.6, 1.35, 0.22
TITLE, WORDS, SMALL = 23, 25, 15
"""Font sizes in points, large enough for a picture that is shown to a class."""

AnyFigure = TypeVar("AnyFigure", bound=Figure)


def held_up_cells(episode: FleetEpisode) -> CellCounts:
    """Return how often robots were held up in each cell, ``[H, W]``; see ``held_up``."""
    layout, held = episode.layout, held_up(episode)
    size = layout.height * layout.width
    return np.bincount(episode.cells[:-1][held], minlength=size).reshape(
        layout.height, layout.width
    )


def congestion_picture(
    episodes: Mapping[str, FleetEpisode],
    title: str,
    make_figure: Callable[[tuple[float, float]], AnyFigure],
) -> AnyFigure:
    """Return heat maps of where robots were held up, with a common scale and the throughputs.

    Args:
        episodes: record of each panel, by its title; all layouts must have the same size.
        title: title of the picture.
        make_figure: function that returns a figure of a given width and height in inches.
    """
    held_up = {name: held_up_cells(episode) for name, episode in episodes.items()}
    highest = max(int(counts.max()) for counts in held_up.values())
    height, width = next(iter(held_up.values())).shape
    cell = min(PANEL / max(height, width), MAX_CELL)
    wide, high = cell * width, cell * height
    bar_left = SPACE + len(held_up) * (wide + SPACE)
    size = bar_left + BAR + 1.1, HEAD + PANEL_HEAD + high + FOOT
    figure = make_figure(size)
    figure.set_facecolor(PAPER)
    style: dict[str, Any] = {"color": INK, "parse_math": False, "va": "center"}

    def write(left: float, top: float, words: str, **options: Any) -> None:
        figure.text(left / size[0], 1 - top / size[1], words, **style, **options)

    write(SPACE, HEAD / 2, title, fontsize=TITLE, fontweight="bold")
    top = HEAD + PANEL_HEAD
    for number, (name, counts) in enumerate(held_up.items()):
        left, episode = SPACE + number * (wide + SPACE), episodes[name]
        axes = figure.add_axes(box_in(size, left, top, wide, high))
        heat = draw_heat(axes, episode.layout.rows, counts, cell * POINTS, highest, digits=False)
        axes.tick_params(labelsize=10)
        share = counts.sum() / max(episode.cells[:-1].size, 1)
        write(left, HEAD + 0.25, name, fontsize=TITLE)
        verdict = f"{episode.measures.per_hour:,.0f} deliveries per hour"
        write(left, top + high + 0.55, verdict, fontsize=WORDS, fontweight="bold")
        words = f"robots held up in {share:.0%} of their steps"
        write(left, top + high + 1.0, words, fontsize=SMALL)
    axes = figure.add_axes(box_in(size, bar_left, top, BAR, high))
    figure.colorbar(heat, cax=axes).outline.set_visible(False)
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    axes.tick_params(length=2, labelsize=SMALL, labelcolor=INK)
    axes.set_ylabel("times robots were held up in a cell", fontsize=SMALL, color=INK)
    return figure
