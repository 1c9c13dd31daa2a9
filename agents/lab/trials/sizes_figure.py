"""A figure that compares agents in several tasks, such as layouts of several sizes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill, wrap
from typing import Any

from agents.lab.trials.figure import (
    CAPTION_LETTERS,
    DPI,
    GREY,
    LETTER,
    MESSAGE_LETTERS,
    ROW_HEIGHT,
    WIDTH,
    draw_failures,
    draw_measure,
    fitting,
    message,
)
from agents.lab.trials.scores import MEASURES, Scores
from warehouse_core.render.palette import INK
from warehouse_core.viz.figure import SceneFigure, make_figure

PANELS = (MEASURES[0], MEASURES[2], MEASURES[1])
"""Deliveries, their steps over the fewest, and steps a delivery."""

LINE, TITLE, ABOVE, BELOW, FOOT = 0.26, 0.3, 0.42, 0.5, 0.55
"""Heights in inches: of a line of a message, of a title, of what stands above and below the panels
of a task, and of the caption."""

RIGHT, GAP = 0.965, 0.055
"""Right end of the panels, and gap between two of them, as shares of the width."""


def sizes_figure(groups: Mapping[str, Mapping[str, Scores]], caption: str = "") -> SceneFigure:
    """Draw the agents' scores in each task, with 95% intervals, under the message they give.

    Args:
        groups: scores by the title of a task and the name of an agent; the same agents in all.
        caption: text below all panels.
    """
    said = [_lines(message(scores)) for scores in groups.values()]
    agents = len(next(iter(groups.values())))
    heights = [LINE * len(lines) + TITLE + ABOVE + ROW_HEIGHT * agents + BELOW for lines in said]
    figure = make_figure((WIDTH, sum(heights) + FOOT), DPI)
    top = sum(heights) + FOOT - 0.12
    for (title, scores), lines, height in zip(groups.items(), said, heights, strict=True):
        _draw_task(figure, top, lines, title, scores)
        top -= height
    words = fill(caption, CAPTION_LETTERS)
    figure.text(0.012, 0.1 / figure.get_figheight(), words, fontsize=9, color=GREY)
    return figure


def _draw_task(
    figure: SceneFigure, top: float, lines: Sequence[str], title: str, scores: Mapping[str, Scores]
) -> None:
    """Draw a message, a title and a row of panels below ``top``, in inches from the bottom."""
    inch = 1 / figure.get_figheight()
    style: dict[str, Any] = {"ha": "left", "va": "top", "parse_math": False}
    said = "\n".join(lines)
    figure.text(0.012, top * inch, said, fontsize=15, fontweight="bold", color=INK, **style)
    top -= LINE * len(lines)
    figure.text(0.012, top * inch, title, fontsize=10, color=GREY, **style)
    names = list(map(fitting, scores))
    left = 0.035 + LETTER * max(map(len, names))
    width = (RIGHT - left - GAP * (len(PANELS) - 1)) / len(PANELS)
    height = ROW_HEIGHT * len(names)
    bottom = top - TITLE - ABOVE - height + 0.12
    for number, measure in enumerate(PANELS):
        box = (left + number * (width + GAP), bottom * inch, width, height * inch)
        axes = figure.add_axes(box)
        draw_measure(axes, measure, names, [measure.of(each) for each in scores.values()])
        if measure is MEASURES[0]:
            draw_failures(axes, scores)
        if number:
            axes.tick_params(labelleft=False)


def _lines(words: str) -> list[str]:
    return [part for line in words.split("\n") for part in wrap(line, MESSAGE_LETTERS)]
