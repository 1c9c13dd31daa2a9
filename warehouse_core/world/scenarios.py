"""Scenario files in MovingAI's ``.scen`` format: pathfinding problems on a map.

In a file ``x`` is the column and ``y`` the row, both counted from 0 at the top left. So ``x, y`` is
the cell ``(y, x)``. Errors give a line and a column of the file, counted from 1 as in editors.

Source: https://movingai.com/benchmarks/formats.html.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.text_lines import (
    error_at,
    expect_line,
    opened,
    read_line,
    read_lines,
    whole_number_at,
)
from warehouse_core.world.tiles import Cell

MAX_SCENARIOS = 100_000
"""Limit on the lines of a file after the first line."""

_LENGTH = re.compile(r"[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")


class Scenario(NamedTuple):
    """A pathfinding problem on a map of ``width`` columns and ``height`` rows.

    Attributes:
        bucket: number of the group of scenarios with about the same difficulty.
        map_name: file name of the map, as written in the scenario.
        octile_length: length in cells of a shortest path with diagonal moves; ``distances``
            returns lengths without them.
    """

    bucket: int
    map_name: str
    width: int
    height: int
    start: Cell
    goal: Cell
    octile_length: float


_FIELDS = (
    "bucket", "map", "width", "height", "start_x", "start_y", "goal_x", "goal_y", "optimal_length"
)  # fmt: skip


def load_scenarios(path: str | Path) -> list[Scenario]:
    """Return the scenarios in a ``.scen`` file.

    The first line is ``version 1``. Each other line is a scenario of 9 columns, separated by tabs
    or spaces. Use ``check_scenarios`` to check whether scenarios fit a layout.

    Raises:
        LayoutError: the file has a different format, or more than ``MAX_SCENARIOS`` lines; the
            message starts with the file's name.
        OSError: the file cannot be read.
    """
    with opened(path) as file:
        expect_line(read_line(file, 1), 1, "version 1", "version 1.0")
        lines = read_lines(file, 2, "MAX_SCENARIOS", MAX_SCENARIOS)
        return [_scenario(line, number) for number, line in lines]


def check_scenarios(layout: Layout, scenarios: Sequence[Scenario]) -> None:
    """Raise an error if scenarios do not fit a layout.

    Raises:
        LayoutError: the size of a scenario differs from the layout's, or a start or goal is off the
            grid or a wall. The message counts scenarios from 1, and rows and columns from 0.
    """
    for number, scenario in enumerate(scenarios, 1):
        if (scenario.height, scenario.width) != (layout.height, layout.width):
            raise LayoutError(
                f"scenario {number} is for {scenario.height} x {scenario.width} cells "
                f"where the layout has {layout.height} x {layout.width}"
            )
        for name, cell in (("start", scenario.start), ("goal", scenario.goal)):
            check_open(layout, cell, f"scenario {number}: {name}")


def _scenario(line: str, number: int) -> Scenario:
    fields = line.split()
    if len(fields) != len(_FIELDS):
        names = " ".join(_FIELDS)
        message = f"{len(fields)} columns where there must be {len(_FIELDS)}: {names}"
        raise error_at(number, _column(line, len(_FIELDS)), message)

    def whole(field: int, minimum: int, size: float = math.inf) -> int:
        """Return the number in a field, at least ``minimum`` and less than ``size``."""
        text, name = fields[field], _FIELDS[field]
        if text.isascii() and text.isdecimal() and minimum <= int(text) < size:
            return int(text)
        column = _column(line, field)
        value = whole_number_at(text, name, minimum, number, column)
        message = f"{name} is {value}; it must be less than the map's {size}"
        raise error_at(number, column, message)

    bucket, width, height = whole(0, 0), whole(2, 1), whole(3, 1)
    start, goal = ((whole(y, 0, height), whole(x, 0, width)) for x, y in ((4, 5), (6, 7)))
    length = float(fields[8]) if _LENGTH.fullmatch(fields[8]) else math.inf
    if not math.isfinite(length):
        message = f"optimal_length is {fields[8]!r}; it must be a number, at least 0"
        raise error_at(number, _column(line, 8), message)
    return Scenario(bucket, fields[1], width, height, start, goal, length)


def _column(line: str, field: int) -> int:
    """Return the column where a field starts, or the column after the line."""
    starts = [word.start() for word in re.finditer(r"\S+", line)]
    return [*starts, len(line)][min(field, len(starts))] + 1
