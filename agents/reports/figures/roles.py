"""Which factor of a design is drawn where: along the axis, as colour, as panel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from agents.experiments.parameters import Value
from agents.reports.analysis.design import Design, Factor
from agents.reports.analysis.results import Experiment, Results

MAX_COLORS, MAX_PANELS = 8, 6

MOST_POINTS = 400
"""In a chart; each takes a bootstrap, and more could not be told apart."""


class Roles(NamedTuple):
    """Which factor goes where.

    Attributes:
        axis: along the axis, with the values that are drawn; ``None`` where nothing differs.
        color: ``None`` where there is one line.
        panel: ``None`` where there is one panel.
        pooled: those that are not shown.
        values: how many the factor along the axis has, drawn or not.
    """

    axis: Factor | None
    color: Factor | None
    panel: Factor | None
    pooled: tuple[Factor, ...]
    values: int = 0


def roles_of(design: Design) -> Roles:
    """Say which factor of a design goes where."""
    left = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    axis = left.pop() if left else None
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MAX_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MAX_PANELS else None
    if axis is None:
        return Roles(None, None, None, ())
    lines = math.prod(len(each.values) for each in (color, panel) if each)
    drawn = Factor(axis.name, tuple(_spread(axis.values, max(MOST_POINTS // lines, 2))))
    return Roles(drawn, color, panel, tuple(left), len(axis.values))


def _spread(values: Sequence[Value], most: int) -> list[Value]:
    """Return so many of some values at most, the first and the last among them."""
    if len(values) <= most:
        return list(values)
    return [values[number * (len(values) - 1) // (most - 1)] for number in range(most)]


Where = tuple[Value | None, Value | None]
"""The values of the panel and of the colour."""


def lines_of(
    experiment: Experiment, design: Design, roles: Roles
) -> dict[Where, dict[Value | None, Results]]:
    """Return the results of each point; one at ``None`` is the same all along the axis."""
    found: dict[Where, dict[Value | None, list[int]]] = {}
    for case_id, labels in design.labels.items():
        panel, color, along = (
            labels[role.name] if role else None for role in (roles.panel, roles.color, roles.axis)
        )
        found.setdefault((panel, color), {}).setdefault(along, []).append(case_id)
    return {
        where: {
            value: experiment.results(*line[value])
            for value in [*(roles.axis.values if roles.axis else ()), None]
            if value in line
        }
        for where, line in sorted(found.items(), key=lambda each: place_of(each[0], roles))
    }


def place_of(where: Where, roles: Roles) -> tuple[int, ...]:
    """Return what lines are sorted by: panels and colours in the order of their values."""
    return tuple(
        factor.values.index(value) if factor and value is not None else -1
        for factor, value in zip((roles.panel, roles.color), where, strict=True)
    )
