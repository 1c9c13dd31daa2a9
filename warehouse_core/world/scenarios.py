"""Scenario files in MovingAI's format ``.scen``: pathfinding problems on a map.

``x`` is the column and ``y`` the row, both counted from 0 with row 0 at the top: ``x, y`` is the
cell ``(y, x)``. Errors give a line and a column of the file, counted from 1, as editors do.

Source: https://movingai.com/benchmarks/formats.html.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from io import BufferedReader
from pathlib import Path
from typing import NamedTuple

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.text_lines import error_at, expect, read_line, whole_number_at
from warehouse_core.world.tiles import Cell

MAX_SCENARIOS = 100_000
"""Limit on the lines of a file after its first."""

_LENGTH = re.compile(r"[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")


class Scenario(NamedTuple):
    """A pathfinding problem on a map.

    Attributes:
        bucket: number of a group of scenarios of about equal difficulty.
        map_name: file name of the map, as given in the scenario.
        width: columns of that map.
        height: rows of that map.
        start: first cell of the path.
        goal: last cell of the path.
        octile_length: length in cells of a shortest path that may use diagonal moves;
            ``distances`` gives the length without them.
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
    """Read a ``.scen``: ``version 1``, then scenarios of 9 columns separated by tabs or spaces.

    ``check_scenarios`` checks whether they fit a layout.

    Raises:
        LayoutError: the file has another format, or more than ``MAX_SCENARIOS`` lines; the message
            starts with the file's name.
        OSError: the file cannot be read.
    """
    with Path(path).open("rb") as file:
        try:
            expect(read_line(file, 1), 1, "version 1", "version 1.0")
            return list(_read_scenarios(file))
        except LayoutError as error:
            raise LayoutError(f"{path}: {error}") from error


def check_scenarios(layout: Layout, scenarios: Sequence[Scenario]) -> None:
    """Raise if scenarios do not fit a layout.

    Raises:
        LayoutError: a size is not the layout's, or a start or goal is off the grid or a wall;
            scenarios are counted from 1, rows and columns from 0.
    """
    for number, scenario in enumerate(scenarios, 1):
        if (scenario.height, scenario.width) != (layout.height, layout.width):
            raise LayoutError(
                f"scenario {number} is for {scenario.height} x {scenario.width} cells "
                f"where the layout has {layout.height} x {layout.width}"
            )
        for name, cell in (("start", scenario.start), ("goal", scenario.goal)):
            check_open(layout, cell, f"scenario {number}: {name}")


def _read_scenarios(file: BufferedReader) -> Iterator[Scenario]:
    number = 2
    while file.peek(1):
        if number > MAX_SCENARIOS + 1:
            raise error_at(number, 1, f"more than MAX_SCENARIOS = {MAX_SCENARIOS} lines")
        line = read_line(file, number)
        if line:
            yield _scenario(line, number)
        number += 1


def _scenario(line: str, number: int) -> Scenario:
    fields = list(re.finditer(r"\S+", line))
    if len(fields) != len(_FIELDS):
        too_many = fields[len(_FIELDS) :]
        raise error_at(
            number,
            too_many[0].start() + 1 if too_many else len(line) + 1,
            f"{len(fields)} columns where there must be {len(_FIELDS)}: {' '.join(_FIELDS)}",
        )
    found = dict(zip(_FIELDS, fields, strict=True))
    bucket = _number_in(found, "bucket", number, 0)
    width, height = (_number_in(found, name, number, 1) for name in ("width", "height"))
    start_x, goal_x = (_number_in(found, name, number, 0, width) for name in ("start_x", "goal_x"))
    start_y, goal_y = (_number_in(found, name, number, 0, height) for name in ("start_y", "goal_y"))
    field = found["optimal_length"]
    length = float(field[0]) if _LENGTH.fullmatch(field[0]) else math.inf
    if not math.isfinite(length):
        message = f"optimal_length is {field[0]!r}; it must be a number, at least 0"
        raise error_at(number, field.start() + 1, message)
    start, goal = (start_y, start_x), (goal_y, goal_x)
    return Scenario(bucket, found["map"][0], width, height, start, goal, length)


def _number_in(
    found: dict[str, re.Match[str]], name: str, line: int, minimum: int, size: float = math.inf
) -> int:
    """Return a whole number of a scenario, at least ``minimum`` and less than ``size``."""
    column = found[name].start() + 1
    number = whole_number_at(found[name][0], name, minimum, line, column)
    if number >= size:
        raise error_at(line, column, f"{name} is {number}; it must be less than the map's {size}")
    return number
