"""The learning curve of a training: deliveries and episode lengths over the training steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import EngFormatter, MaxNLocator, PercentFormatter

from agents.lab.training.exams import ExamPoint, mean_length
from agents.lab.trials.interval import Interval
from agents.lab.trials.scores import FleetScores, Scores
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import INK, PAPER, WARNING, color_named
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure

SIZE, DPI = (9.0, 3.8), 150
STEP_TICKS = [digit * 10**power for power in range(9) for digit in (1, 2, 5)]
ROOM = 1.5
"""Factor by which the axis extends beyond the lowest and highest values, for the line names."""

LEARNER, GREEDY = color_named("accent"), WARNING


def save_learning_curve(
    path: Path, name: str, title: str, points: Sequence[ExamPoint], greedy: Scores | FleetScores
) -> None:
    """Write the learning curve as a PNG file, and leave no incomplete file after an error."""
    figure = learning_curve(name, title, points, greedy)
    with atomic_path(path) as part:
        figure.pixels().save(part, format="PNG")


def learning_curve(
    name: str, title: str, points: Sequence[ExamPoint], greedy: Scores | FleetScores
) -> SceneFigure:
    """Draw the learning curve of an agent next to the scores of the greedy agent.

    Args:
        name: name of the agent.
        title: title of the figure.
        points: exams, of which there must be at least one.
        greedy: scores of the greedy agent.
    """
    figure = make_figure(SIZE, DPI)
    left, right = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.065, right=0.975, top=0.82, bottom=0.21, wspace=0.16)
    figure.suptitle(title, x=0.065, y=0.97, ha="left", fontsize=12, color=INK)
    method = "Wilson"
    if isinstance(greedy, FleetScores):
        method = "bootstrap"
        rate, blocked = "deliveries per hour", "share of steps blocked by other robots"
        _draw(left, f"{rate} (mean)", name, points, greedy, lambda each: each.per_hour, "{:.0f}")
        _draw(right, f"{blocked} (mean)", name, points, greedy, lambda each: each.blocked, "{:.1%}")
        right.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        for axes in (left, right):
            high = axes.get_ylim()[1]
            axes.set_ylim(-0.1 * high, 1.1 * high)
    else:
        success = "deliveries, share of random starts"
        _draw(left, success, name, points, greedy, lambda each: each.success, "{:.1%}")
        left.set_ylim(-0.1, 1.1)
        left.set_yticks(np.linspace(0, 1, 6))
        left.yaxis.set_major_formatter(PercentFormatter(1.0))
        _draw_lengths(right, name, points, greedy)
    count = len(points[0].scores.rows)
    caption = (
        f"each point: the same {count:,} random starts; band: 95% interval ({method});  "
        f"greedy: {len(greedy.rows):,} random starts"
    )
    figure.text(0.065, 0.03, caption, fontsize=8.5, color="0.4")
    return figure


def _draw_lengths(axes: Axes, name: str, points: Sequence[ExamPoint], greedy: Scores) -> None:
    def length(scores: Any) -> Interval:
        return Interval(mean_length(scores))

    title = "steps per episode, including failures (mean)"
    _draw(axes, title, name, points, greedy, length, "{:.1f} steps")
    axes.set_yscale("log")
    each: list[Any] = [greedy, *(point.scores for point in points)]
    lengths = [mean_length(scores) for scores in each]
    low, high = min(lengths) / ROOM, max(lengths) * ROOM
    ticks = [tick for tick in STEP_TICKS if low <= tick <= high]
    axes.set_yticks(ticks, labels=map(str, ticks))
    axes.set_yticks([], minor=True)
    axes.set_ylim(low, high)


def _draw(
    axes: Axes,
    title: str,
    name: str,
    points: Sequence[ExamPoint],
    greedy: Scores | FleetScores,
    measure: Callable[[Any], Interval],
    form: str,
) -> None:
    """Draw the learner's line with its band and the greedy agent's line.

    Each line is labelled with its name and final value. The labels are above the higher line and
    below the lower one, so that they cannot overlap.
    """
    axes.set_title(title, fontsize=9.5, loc="left", color=INK, pad=6)
    axes.set_xlabel("training steps", fontsize=8.5, color=INK)
    axes.set_xlim(0, points[-1].steps * 1.01)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=6))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    style_chart(axes)
    steps, level = [point.steps for point in points], measure(greedy).estimate
    values, low, high = zip(*(measure(point.scores) for point in points), strict=True)
    axes.fill_between(steps, low, high, color=LEARNER, alpha=0.18, linewidth=0)
    axes.axhline(level, color=GREEDY, linewidth=1.4, linestyle=(0, (5, 2)))
    axes.plot(steps, values, "-o", color=LEARNER, linewidth=1.8, markersize=3)
    lines = [(name, values[-1], LEARNER), ("greedy", level, GREEDY)]
    lower, higher = sorted(lines, key=lambda line: line[1])
    for (who, value, color), above in ((lower, False), (higher, True)):
        axes.annotate(
            f"{who} {form.format(value)}",
            (points[-1].steps, value),
            xytext=(0, 5 if above else -5),
            textcoords="offset points",
            ha="right",
            va="bottom" if above else "top",
            fontsize=9,
            fontweight="bold",
            color=color,
            path_effects=[withStroke(linewidth=3, foreground=PAPER)],
        )
