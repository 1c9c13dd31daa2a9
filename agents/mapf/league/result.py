"""Results in the League's output format, as PlanViz reads them.

Files of 2023 are read; results of problems of 2023 are written in the format of 2024. Rows of
arrays are steps, and ``R`` is the number of robots.

Source: ``Input_Output_Format.md`` of the League's Start-Kit, 1.1.5, 2.1.2 and 3.1.0.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.errors import PlanError
from agents.mapf.league.rules import LETTERS
from agents.mapf.league.tasks import Errand, ScheduleError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.json_text import parse_object
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

__all__ = ["Result", "read_result", "write_result"]

MAX_RESULT = 512 * 2**20
"""Limit on the bytes of a result."""

MAX_ITEMS = 20_000_000
"""Limit on the values of a result, of which actions are none."""

SEGMENT = 1000
"""Ticks of a segment of a path of 2026."""

EAST = "E"
"""The letter of the heading at the start."""


@dataclass(eq=False)
class Result:
    """What was planned and done in a game; ``play`` returns it.

    Attributes:
        year: year of the format.
        ticks: ticks of a move or a turn.
        starts: ``[R]``, cells in which the robots start, heading east.
        actual: ``[T, R]`` uint8, actions that were carried out, as indices in ``LETTERS``.
        planned: ``[T, R]`` uint8, actions that were planned.
        finished: number of finished tasks.
        late: number of steps that passed because a plan was late.
        errors: errors of joint actions: two robots or ``NOBODY``, the step, and words.
        seconds: time of each plan.
        tasks: step at which each task was revealed, and its cells; empty if not in a file.
        errands: visits to cells of tasks.
        schedule: ``[R]`` lists of pairs: step of each change of a robot's task, and the new one.
        schedule_errors: errors of schedules.
        delays: ``[R]`` lists of pairs: the first tick of a delay, and the tick after its last.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.league.result import Result
        >>> forward = np.array([[0], [0]], np.uint8)
        >>> result = Result(2024, 1, np.array([5]), forward, forward, 0, 0, [], [0.1, 0.1])
        >>> result.actual.shape
        (2, 1)
    """

    year: int
    ticks: int
    starts: Integers
    actual: NDArray[np.uint8]
    planned: NDArray[np.uint8]
    finished: int
    late: int
    errors: list[tuple[int, int, int, str]]
    seconds: list[float]
    tasks: list[tuple[int, tuple[int, ...]]] = field(default_factory=list)
    errands: list[Errand] = field(default_factory=list)
    schedule: list[list[tuple[int, int]]] = field(default_factory=list)
    schedule_errors: list[ScheduleError] = field(default_factory=list)
    delays: list[list[tuple[int, int]]] = field(default_factory=list)


def write_result(path: Path, result: Result, layout: Layout) -> None:
    """Write a result, whole or not at all.

    Args:
        path: path of the file.
        result: result to write.
        layout: layout of the problem.

    Raises:
        OSError: the file cannot be written.

    Example:
        >>> from pathlib import Path
        >>> import numpy as np
        >>> from agents.mapf.league.result import Result, write_result
        >>> from warehouse_core import Layout
        >>> forward = np.array([[0], [0]], np.uint8)
        >>> result = Result(2024, 1, np.array([1]), forward, forward, 0, 0, [], [0.1, 0.1])
        >>> write_result(Path("result.json"), result, Layout(["....", "...."]))
    """
    starts = layout.places(result.starts).tolist()
    schedule = [",".join(f"{step}:{task}" for step, task in each) for each in result.schedule]
    written: dict[str, Any] = {
        "actionModel": "MAPF_T",
        "version": f"{max(result.year, 2024)} LoRR",
        "teamSize": len(starts),
        "start": [[*place, EAST] for place in starts],
        "numTaskFinished": result.finished,
        "makespan": len(result.actual),
        "numPlannerErrors": len(result.errors),
        "numScheduleErrors": len(result.schedule_errors),
        "numEntryTimeouts": result.late,
        "plannerTimes": result.seconds,
        "errors": result.errors,
        "actualSchedule": schedule,
        "plannerSchedule": schedule,
        "scheduleErrors": [[*error] for error in result.schedule_errors],
        "events": [[*errand] for errand in result.errands],
        "tasks": [
            [number, step, layout.places(np.array(cells)).ravel().tolist()]
            for number, (step, cells) in enumerate(result.tasks)
        ],
    }
    if result.year == 2026:
        written |= {
            "agentMaxCounter": result.ticks,
            "outputSegmentSize": SEGMENT,
            "delayIntervals": result.delays,
        }
    for key, actions in (("actualPaths", result.actual), ("plannerPaths", result.planned)):
        texts = ["".join(LETTERS[action] for action in column) for column in actions.T.tolist()]
        if result.year == 2026:
            written[key] = [
                segments(text, start, result.ticks)
                for text, start in zip(texts, starts, strict=True)
            ]
        else:
            written[key] = [",".join(text) for text in texts]
    with atomic_path(path) as part:
        part.write_text(json.dumps(written), encoding="utf-8")


def segments(letters: str, place: Sequence[int], ticks: int) -> str:
    """Return the path of a robot in the format of 2026.

    Args:
        letters: action of each tick.
        place: row and column of the start.
        ticks: ticks of a move or a turn.
    """
    (row, column), heading, count, found = place, 0, 0, []
    for start in range(0, len(letters), SEGMENT):
        segment = letters[start : start + SEGMENT]
        runs = [f"{letter} {len(list(run))}" for letter, run in groupby(segment)]
        found.append(f"[({start},{row},{column},{heading},{count}):({','.join(runs)})]")
        for letter in segment:
            count += letter in "FRC"
            if count == ticks:
                count = 0
                row += (letter == "F") * (heading == 1) - (letter == "F") * (heading == 3)
                column += (letter == "F") * (heading == 0) - (letter == "F") * (heading == 2)
                heading = (heading + {"R": 1, "C": 3}.get(letter, 0)) % 4
    return "".join(found)


def read_result(path: Path, layout: Layout) -> Result:
    """Read a result of a problem with a layout.

    Raises:
        PlanError: the file is not such a result.
        OSError: the file cannot be read.

    Example:
        >>> from pathlib import Path
        >>> import numpy as np
        >>> from agents.mapf.league.result import Result, read_result, write_result
        >>> from warehouse_core import Layout
        >>> layout, forward = Layout(["....", "...."]), np.array([[0], [0]], np.uint8)
        >>> result = Result(2024, 1, np.array([1]), forward, forward, 0, 0, [], [0.1, 0.1])
        >>> write_result(Path("result.json"), result, layout)
        >>> read_result(Path("result.json"), layout).actual.tolist()
        [[0], [0]]
    """
    data = read_file(path, MAX_RESULT)
    for letter in LETTERS.encode():
        data = data.replace(bytes([letter, 44]), bytes([letter]))  # actions are many values, else
    try:
        return _result_of(parse_object(data, MAX_RESULT, MAX_ITEMS), layout)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise PlanError(f"{path}: no result of the League: {_reason(error)}") from error


def _reason(error: Exception) -> str:
    return f"{error} is missing" if isinstance(error, KeyError) else str(error)


def _result_of(given: dict[str, Any], layout: Layout) -> Result:
    if given["actionModel"] != "MAPF_T":
        raise ValueError(f"actionModel is {brief(given['actionModel'])}; it must be MAPF_T")
    starts = [start[:2] for start in given["start"]]
    if odd := [start for start in given["start"] if start[2] != EAST]:
        raise ValueError(f"start {brief(odd[0])}; robots start heading {EAST}")
    actual = _actions(given["actualPaths"])
    planned = _actions(given["plannerPaths"]) if "plannerPaths" in given else actual[:0]
    version = given.get("version", "")
    year = int(version[:4]) if version else 2023
    tasks, errands, schedule = (_of_2023 if year == 2023 else _of_2024)(given, layout)
    return Result(
        year, int(given.get("agentMaxCounter", 1)), _numbers(starts, layout), actual, planned,
        int(given["numTaskFinished"]), int(given.get("numEntryTimeouts", 0)),
        [tuple(error) for error in given.get("errors", ())], given.get("plannerTimes", []),
        tasks, errands, schedule,
        [ScheduleError(*each) for each in given.get("scheduleErrors", ())],
        [[(int(a), int(b)) for a, b in each] for each in given.get("delayIntervals", ())],
    )  # fmt: skip


def _numbers(places: Sequence[Any], layout: Layout) -> Integers:
    """Return the numbers of places of a layout: pairs, or their numbers one after the other."""
    found = np.array(places, np.int64).reshape(-1, 2)
    if ((found < 0) | (found >= (layout.height, layout.width))).any():
        raise ValueError("a place is not on the map")
    return found[:, 0] * layout.width + found[:, 1]


def _actions(paths: Sequence[str]) -> NDArray[np.uint8]:
    """Return the actions of paths without commas, ``[T, R]``."""
    if paths and paths[0][:1] == "[":
        paths = [_long(path) for path in paths]
    letters = np.array([np.frombuffer(path.encode(), np.uint8) for path in paths])
    table = np.full(256, len(LETTERS), np.uint8)
    table[list(LETTERS.encode())] = range(len(LETTERS))
    found: NDArray[np.uint8] = table[letters]
    if (found == len(LETTERS)).any():
        raise ValueError(f"an action of a path is none of {', '.join(LETTERS)}")
    actions: NDArray[np.uint8] = found.T
    return actions


def _long(path: str) -> str:
    """Return a path of 2026 with a letter for each tick."""
    pairs = re.findall(r"([A-Z]) (\d+)", path)
    return "".join(letter * int(number) for letter, number in pairs)


def _of_2024(given: dict[str, Any], layout: Layout) -> tuple[Any, Any, Any]:
    """Return tasks, errands and the schedule."""
    tasks = [
        (int(step), tuple(_numbers(places, layout).tolist()))
        for _, step, places in given.get("tasks", ())
    ]
    schedule = [
        [tuple(map(int, each.split(":"))) for each in text.split(",") if each]
        for text in given.get("actualSchedule", ())
    ]
    return tasks, [Errand(*errand) for errand in given.get("events", ())], schedule


def _of_2023(given: dict[str, Any], layout: Layout) -> tuple[Any, Any, Any]:
    """Return tasks, errands and the schedule."""
    cells = _numbers([place for _, *place in given.get("tasks", ())], layout).tolist()
    revealed, errands = [0] * len(cells), []
    schedule: list[list[tuple[int, int]]] = []
    for robot, events in enumerate(given.get("events", ())):
        schedule.append(
            [(int(step), int(task)) for task, step, word in events if word == "assigned"]
        )
        for step, task in schedule[-1]:
            revealed[task] = step
        errands += [
            Errand(step, robot, task, 1) for task, step, word in events if word == "finished"
        ]
    return [(step, (cell,)) for step, cell in zip(revealed, cells, strict=True)], errands, schedule
