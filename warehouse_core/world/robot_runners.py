"""Problems of the League of Robot Runners: ``.json``, and their ``.tasks`` and ``.agents``.

A problem names the files of its map, its robots and its tasks. The first line of the latter two is
a number of tasks or robots; a line for each follows. A location is one whole number,
``row * W + col`` on a map of ``W`` columns, from 0. Lines that start with ``#`` are comments.
``load_map`` with ``robot_runners=True`` reads the maps.

| year | tasks                               | actions          |
| ---- | ----------------------------------- | ---------------- |
| 2023 | of one location, given to robots    | of one step      |
| 2024 | of several locations, in one pool   | of one step      |
| 2026 | of several locations, in one pool   | of several ticks |

Source: ``Input_Output_Format.md`` of the League's Start-Kit, 1.1.5, 2.1.2 and 3.1.0; for defaults
and comments its ``src/driver.cpp``, ``inc/common.h`` and the files in ``example_problems``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple

from warehouse_core.errors import LayoutError
from warehouse_core.files.json_text import parse_object
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.map_files import load_map
from warehouse_core.world.text_lines import error_at, opened, read_lines, whole_number_at
from warehouse_core.world.tiles import Cell

MAX_LOCATIONS = 1_000_000
"""Limit on the locations of a file, of which each task or robot has at least one."""

MAX_LINES = 2 * MAX_LOCATIONS
"""Limit on the lines of a file, comments and empty lines included."""

MAX_PROBLEM = 100_000
"""Limit on the bytes of a problem, which only names other files."""

MAX_NAMED = 10
"""Limit on the fields without effect that a warning names."""

ROUND_ROBIN, FIXED, GREEDY = "roundrobin", "roundrobin_fixed", "greedy"
STRATEGIES = (ROUND_ROBIN, FIXED, GREEDY)
"""Values of ``taskAssignmentStrategy``, by which tasks were given to robots in 2023.

Task ``k`` of robot ``r`` of ``R`` is task ``k * R + r``, which begins again after the last, or does
not. Or the next task is given to the first robot that needs one.
"""

EVENTS, DURATIONS = ("bernoulli", "poisson"), ("uniform", "gaussian")
"""Values of ``eventModel`` and ``durationModel``."""

MAX_TICKS = 1_000
"""Limit on the ticks of an action and of a delay."""

TICKS_2026 = 10
"""Ticks of an action of 2026 that does not say how many."""


class Delays(NamedTuple):
    """How the delays of robots are drawn.

    Attributes:
        seed: random seed.
        shortest, longest: limits on the ticks of a delay.
        event: ``bernoulli``: each robot that has no delay gets one with the probability, in each
            tick. ``poisson``: so do as many robots as a Poisson distribution says, whose mean is
            the probability times the number of robots.
        probability: see ``event``.
        duration: ``uniform`` or ``gaussian`` distribution of ticks.
        mean, deviation: of ``gaussian``, relative to ``longest - shortest``; the mean is counted
            from ``shortest``.
    """

    seed: int
    shortest: int
    longest: int
    event: str
    probability: float
    duration: str
    mean: float
    deviation: float


class League(NamedTuple):
    """A problem of the League.

    Attributes:
        starts: cells in which the robots start, all different, heading east.
        tasks: cells that each task visits, in this order; at least one task.
        revealed: number of unfinished tasks that are known at a time.
        strategy: one of ``STRATEGIES``, or ``""`` where a scheduler gives tasks to robots.
        year: 2023, 2024 or 2026.
        ticks: number of ticks that a move or a turn takes.
        robot_size: side of the square that a robot takes, in cells.
        delays: distribution of the delays of robots, or ``None``.
    """

    layout: Layout
    starts: list[Cell]
    tasks: list[tuple[Cell, ...]]
    revealed: int
    strategy: str = ""
    year: int = 2024
    ticks: int = 1
    robot_size: float = 1.0
    delays: Delays | None = None


def load_league(path: str | Path) -> League:
    """Read a problem, and the files that it names, relative to its folder.

    A warning names fields that are not known.

    Raises:
        LayoutError: the file is not such a problem, there are fewer starts than ``teamSize``, two
            robots have one start, there is no task, a task that is given to a robot has several
            locations, or one of its files has another format.
        OSError: a file cannot be read.
    """
    path = Path(path)
    data = read_file(path, MAX_PROBLEM)
    try:
        given = parse_object(data)
        team = _given(given, "teamSize", int, 1)
        reveal = _given(given, "numTasksReveal", float, 0, default=1.0)
        files = [path.parent / _given(given, f"{name}File", str) for name in _FILES]
        strategy = _given(given, "taskAssignmentStrategy", str, allowed=STRATEGIES, default="")
        version = _given(given, "version", str, default="")
        is_2026 = version.startswith("2026") or not given.keys().isdisjoint(_OF_2026)
        ticks = _given(
            given, "agentCounter", int, 1, MAX_TICKS, default=TICKS_2026 if is_2026 else 1
        )
        size = _given(given, "agentSize", float, 0.001, 1, default=1.0)
        delays = _delays(given)
    except ValueError as error:
        raise LayoutError(f"{path}: {error}") from error
    if unknown := given.keys() - _FIELDS:
        names = ", ".join(map(brief, sorted(unknown)[:MAX_NAMED]))
        more = ", ..." if len(unknown) > MAX_NAMED else ""
        warnings.warn(f"{path}: fields without effect: {names}{more}", stacklevel=2)
    layout = load_map(files[0], robot_runners=True).with_tiles([], [], [])
    starts, tasks = load_agents(files[1], layout)[:team], load_tasks(files[2], layout)
    if len(starts) < team:
        raise LayoutError(f"{path}: teamSize is {team}, but {files[1]} has {len(starts)} robots")
    if not tasks:
        raise LayoutError(f"{path}: {files[2]} has no tasks; it must have one or more")
    for number, task in enumerate(tasks):
        if strategy and len(task) > 1:
            raise LayoutError(
                f"{files[2]}: task {number} has {len(task)} locations; with "
                "taskAssignmentStrategy it must have one"
            )
    first: dict[Cell, int] = {}
    for robot, cell in enumerate(starts):
        if first.setdefault(cell, robot) != robot:
            raise LayoutError(f"{files[1]}: robots {first[cell]} and {robot} both start in {cell}")
    revealed = max(1, int(reveal)) * team if strategy else max(1, int(reveal * team))
    year = 2023 if strategy else 2026 if is_2026 else 2024
    return League(layout, starts, tasks, revealed, strategy, year, ticks, size, delays)


_FILES = ("map", "agent", "task")
_OF_2026 = {"agentCounter", "agentSize", "delayConfig"}
_FIELDS = {
    "teamSize", "numTasksReveal", "taskAssignmentStrategy", "version",
    *_OF_2026, *(f"{name}File" for name in _FILES),
}  # fmt: skip


def _delays(problem: dict[str, Any]) -> Delays | None:
    """Return ``delayConfig``, or ``None`` without one."""
    if "delayConfig" not in problem:
        return None
    given = problem["delayConfig"]
    if not isinstance(given, dict):
        raise LayoutError(f"delayConfig is {brief(given)}; it must be an object")
    try:
        seed = _given(given, "seed", int, 0, 2**32 - 1)
        shortest = _given(given, "minDelay", int, 1, MAX_TICKS)
        return Delays(
            seed,
            shortest,
            _given(given, "maxDelay", int, shortest, MAX_TICKS),
            _given(given, "eventModel", str, allowed=EVENTS),
            _given(given, "pDelay", float, 0, 1),
            _given(given, "durationModel", str, allowed=DURATIONS),
            _given(given, "gaussMeanRatio", float, 0, 1),
            _given(given, "gaussStdRatio", float, 0, 1),
        )
    except LayoutError as error:
        raise LayoutError(f"delayConfig: {error}") from error


def _given(
    given: dict[str, Any],
    key: str,
    kind: type,
    least: float | None = None,
    most: float = MAX_LOCATIONS,
    allowed: Sequence[str] = (),
    default: Any = None,
) -> Any:
    """Return the value of a key, a text or a number, or the default, if there is one."""
    kinds = {str: "a text", int: "a whole number", float: "a number"}
    if key not in given:
        if default is not None:
            return default
        raise LayoutError(f"{key} is missing; it must be {kinds[kind]}")
    value = given[key]
    is_kind = type(value) is kind or (kind is float and type(value) is int)
    if not is_kind or (least is not None and not least <= value <= most):
        limits = "" if least is None else f", {least} to {most}"
        raise LayoutError(f"{key} is {brief(value)}; it must be {kinds[kind]}{limits}")
    if allowed and value not in allowed:
        raise LayoutError(f"{key} is {brief(value)}; allowed: {', '.join(allowed)}")
    if kind is str and "\0" in value:
        raise LayoutError(f"{key} is {brief(value)}; a file name has no null character")
    return value


def load_agents(path: str | Path, layout: Layout) -> list[Cell]:
    """Read a ``.agents`` for a map: the start of each robot; raise errors as ``load_tasks``."""
    return [cell for [cell] in _load(path, layout, "robots", 1)]


def load_tasks(path: str | Path, layout: Layout) -> list[tuple[Cell, ...]]:
    """Read a ``.tasks`` for a map: the cells that each task visits, one or more, in this order.

    Raises:
        LayoutError: the file has another format, a location is not an open cell of the layout, or
            there are more than ``MAX_LOCATIONS``; the message starts with the file's name.
        OSError: the file cannot be read.
    """
    return _load(path, layout, "tasks")


def _load(
    path: str | Path, layout: Layout, entries: str, most: int | None = None
) -> list[tuple[Cell, ...]]:
    with opened(path) as file:
        return list(_read(file, layout, entries, most))


def _read(
    file: BufferedReader, layout: Layout, entries: str, most: int | None
) -> Iterator[tuple[Cell, ...]]:
    lines = _lines(file)
    number, text = next(lines)
    count = whole_number_at(text, f"number of {entries}", 0, number, 1)
    _check_number(count, entries, number)
    known: dict[str, Cell] = {}
    locations = 0
    for _ in range(count):
        number, text = next(lines)
        if not text:
            raise error_at(number, 1, f"the file ends here; its number of {entries} is {count}")
        fields = text.split(",")
        locations += len(fields)
        _check_number(locations, "locations", number)
        if most is not None and len(fields) > most:
            raise error_at(number, 1, f"{len(fields)} locations where there must be {most}")
        for place, field in enumerate(fields):
            if field not in known:
                column = len(",".join(["", *fields[:place]])) + 1
                known[field] = _cell(field, number, column, layout)
        yield tuple(map(known.__getitem__, fields))
    number, text = next(lines)
    if text:
        raise error_at(number, 1, f"the file goes on here; its number of {entries} is {count}")


def _check_number(count: int, entries: str, line: int) -> None:
    if count > MAX_LOCATIONS:
        raise error_at(line, 1, f"{count} {entries} are more than MAX_LOCATIONS = {MAX_LOCATIONS}")


def _lines(file: BufferedReader) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line with content; the end of the file is an empty text."""
    number = 0
    for number, line in read_lines(file, 1, "MAX_LINES", MAX_LINES):
        if line[0] != "#":
            yield number, line
    yield number + 1, ""


def _cell(field: str, line: int, column: int, layout: Layout) -> Cell:
    """Return the cell of a location, the field of a line that starts at a column."""
    column += len(field) - len(field.lstrip())
    location = whole_number_at(field.strip(), "location", 0, line, column)
    cell = layout.cell(location)
    if not layout.is_open(cell):
        message = f"location {location}, {layout.describe(cell)}; it must be an open cell"
        raise error_at(line, column, message)
    return cell
