"""Which factor of a design is drawn along the axis, as colour and as panel."""

from __future__ import annotations

import math
from itertools import product
from typing import NamedTuple

from agents.lab.parameters import Value
from agents.lab.reports.analysis.design import Design, Factor
from agents.lab.reports.analysis.results import Experiment, Results

MAX_COLORS, MAX_PANELS = 8, 6

MAX_POINTS = 400
"""Most points of a chart; each takes a bootstrap, and more could not be distinguished."""


class Roles(NamedTuple):
    """The factors along the axis, of the lines and of the panels, if any; others are pooled.

    The axis has the values that are drawn, of so many in all.
    """

    axis: Factor | None
    color: Factor | None
    panel: Factor | None
    pooled: tuple[Factor, ...]
    values: int = 0


def roles_of(design: Design) -> Roles:
    """Return which factor of a design is drawn where."""
    if not design.factors:
        return Roles(None, None, None, ())
    *left, axis = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MAX_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MAX_PANELS else None
    lines = math.prod(len(each.values) for each in (color, panel) if each)
    count = len(axis.values)
    drawn = min(count, max(MAX_POINTS // lines, 2))
    # The first, the last, and those at equal distances between them.
    values = tuple(axis.values[number * (count - 1) // (drawn - 1)] for number in range(drawn))
    return Roles(Factor(axis.name, values), color, panel, tuple(left), count)


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
    panels, colors, values = (
        role.values if role else () for role in (roles.panel, roles.color, roles.axis)
    )
    return {
        where: {
            value: experiment.results(*found[where][value])
            for value in (*values, None)
            if value in found[where]
        }
        for where in product((None, *panels), (None, *colors))
        if where in found
    }
