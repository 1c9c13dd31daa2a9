"""Which factor of a design is drawn along the axis, as colour and as panel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from agents.experiments.parameters import Value
from agents.reports.analysis.design import Design, Factor
from agents.reports.analysis.results import Experiment, Results

MAX_COLORS, MAX_PANELS = 8, 6

MAX_POINTS = 400
"""In a chart; each takes a bootstrap, and more could not be distinguished."""


class Roles(NamedTuple):
    """The factors of a chart.

    Attributes:
        axis: along the axis, with the values that are drawn; ``None`` if nothing differs.
        color: ``None`` if there is one line in a panel.
        panel: ``None`` if there is one panel.
        pooled: those that are not shown.
        values: the number of all values of the factor along the axis.
    """

    axis: Factor | None
    color: Factor | None
    panel: Factor | None
    pooled: tuple[Factor, ...]
    values: int = 0


def roles_of(design: Design) -> Roles:
    """Return which factor of a design is drawn where."""
    left = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    axis = left.pop() if left else None
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MAX_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MAX_PANELS else None
    if axis is None:
        return Roles(None, None, None, ())
    lines = math.prod(len(each.values) for each in (color, panel) if each)
    drawn = Factor(axis.name, tuple(_spread(axis.values, max(MAX_POINTS // lines, 2))))
    return Roles(drawn, color, panel, tuple(left), len(axis.values))


def _spread(values: Sequence[Value], maximum: int) -> list[Value]:
    """Return at most ``maximum`` of some values, with the first and the last."""
    if len(values) <= maximum:
        return list(values)
    return [values[number * (len(values) - 1) // (maximum - 1)] for number in range(maximum)]


Where = tuple[Value | None, Value | None]
"""The values of the panel and of the colour."""


def lines_of(
    experiment: Experiment, design: Design, roles: Roles
) -> dict[Where, dict[Value | None, Results]]:
    """Return the results of each point; the one at ``None`` is the same along the whole axis."""
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
        for where, line in sorted(found.items(), key=lambda each: _rank(each[0], roles))
    }


def _rank(where: Where, roles: Roles) -> tuple[int, ...]:
    """Return the sort key of a line: panels and colours in the order of their values."""
    return tuple(
        factor.values.index(value) if factor and value is not None else -1
        for factor, value in zip((roles.panel, roles.color), where, strict=True)
    )
