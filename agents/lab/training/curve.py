"""The learning curve of a training, in the style of reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.ticker import EngFormatter, MaxNLocator

from agents.lab.training.exams import ExamPoint, mean_length
from agents.lab.trials.figure import BOUND, PIXELS, draw_legend, make_panels, scale_axis
from agents.lab.trials.interval import CONFIDENCE, Interval
from agents.lab.trials.scores import FleetScores, Scores
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import SERIES
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.wording import printable

Panels = dict[str, tuple[Callable[[Any], Interval], str, str]]
"""Measure, format of a value and unit of the axis, by the beginning of the title of a panel."""

OF_ONE: Panels = {
    "delivered": (lambda scores: scores.success, "{:.1%}", "%"),
    "mean steps": (lambda scores: Interval(mean_length(scores)), "{:.1f}", "steps"),
}
OF_FLEETS: Panels = {
    "per hour": (lambda scores: scores.per_hour, "{:.0f}", "deliveries per hour"),
    "blocked": (lambda scores: scores.blocked, "{:.1%}", "%"),
}


def save_learning_curve(
    path: Path, name: str, title: str, points: Sequence[ExamPoint], greedy: Scores | FleetScores
) -> None:
    """Write the learning curve as a PNG file, and leave no incomplete file after an error."""
    figure = learning_curve(name, title, points, greedy)
    with atomic_path(path) as part:
        figure.pixels().save(part, format="PNG")


@mpl.rc_context({"text.parse_math": False})
def learning_curve(
    name: str, title: str, points: Sequence[ExamPoint], greedy: Scores | FleetScores
) -> SceneFigure:
    """Draw the learning curve of an agent next to the scores of the greedy agent.

    Steps of episodes include failures. The titles of the panels have the final values.

    Args:
        name: name of the agent.
        title: title of the figure.
        points: exams, of which there must be at least one.
        greedy: scores of the greedy agent.
    """
    panels = OF_FLEETS if isinstance(greedy, FleetScores) else OF_ONE
    titles = [
        f"{each}: {form.format(of(points[-1].scores).estimate)}, "
        f"greedy {form.format(of(greedy).estimate)}"
        for each, (of, form, _) in panels.items()
    ]
    labels = [f"{printable(name)}, with {CONFIDENCE:.0%} intervals", "greedy"]
    written = EngFormatter(sep="").format_eng
    rounded = MaxNLocator(5).tick_values(0, points[-1].steps)
    places = {written(each): float(each) for each in rounded if 0 <= each <= points[-1].steps}
    figure, all_axes = make_panels(title, titles, labels, "training steps", places, len(titles))
    steps = [each.steps for each in points]
    for axes, (of, _, unit) in zip(all_axes, panels.values(), strict=True):
        values, low, high = zip(*(of(each.scores) for each in points), strict=True)
        axes.fill_between(steps, low, high, color=SERIES[0], alpha=0.18, linewidth=0)
        learned = axes.plot(steps, values, "-o", color=SERIES[0], linewidth=1.6, markersize=3)
        level = axes.axhline(of(greedy).estimate, **BOUND)
        scale_axis(axes, unit)
    draw_legend(figure, title, dict(zip(labels, (*learned, level), strict=True)))
    figure.set_dpi(PIXELS)
    return figure
