"""Grades of a class: their table and summary, and files for Moodle and Canvas.

The table is a CSV file with a row for each submission. Moodle and Canvas put a number for each
student into the names of the files that they hand out, and this number identifies the student. Any
other name counts as the login of the student.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from io import StringIO
from pathlib import Path
from statistics import mean, median

from agents.errors import GradeError
from agents.lab.grading.grading import Grade, GradeReport
from agents.lab.grading.rubric import MAX_DAYS, TAKEN, Rubric
from agents.lab.grading.students import CANVAS, MOODLE
from agents.lab.trials.wording import percent
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file
from warehouse_core.wording import counted, printable, spreadsheet_text

NAME, POINTS, MOST, LATE, FAILURE, OUTCOMES, CODE, RUBRIC = TAKEN

DAYS = "days"
"""Column of a table of late submissions."""

MAX_BYTES, MAX_COLUMNS = 5_000_000, 1_000
"""Limits on the bytes of a table (enough for ten thousand submissions) and on its columns."""

GradeRow = dict[str, str]


def columns_of(rubric: Rubric) -> list[str]:
    """Return the columns of the table of grades for a rubric."""
    names = (each.name for each in rubric.criteria)
    return [NAME, POINTS, MOST, *names, LATE, FAILURE, OUTCOMES, CODE, RUBRIC]


def row_of(name: str, report: GradeReport) -> GradeRow:
    """Return the row of a graded submission."""
    return {
        NAME: plain(name), POINTS: f"{report.points:g}", MOST: f"{report.max_points:g}",
        **{each.criterion.name: f"{each.points:g}" for each in report.grades},
        LATE: str(report.late),
        FAILURE: plain("" if report.points else "; ".join(report.remarks)),
        OUTCOMES: report.outcomes, CODE: report.code, RUBRIC: report.rubric,
    }  # fmt: skip


def failed_row(name: str, reason: str, rubric: Rubric, code: str = "", late: int = 0) -> GradeRow:
    """Return the row of a submission that could not be graded, without points."""
    failed = GradeReport(
        "", "", rubric.digest, code, tuple(Grade(each, 0.0, "") for each in rubric.criteria),
        failure=reason, reason="", episodes=0, late=late,
    )  # fmt: skip
    return row_of(name, failed)


def plain(text: str) -> str:
    """Return text that no spreadsheet runs as a formula, and no terminal as a command."""
    return spreadsheet_text(printable(text))


def load_grades(path: Path) -> dict[str, GradeRow]:
    """Return the rows of a table of grades by the name of the submission, or {} without a file.

    Raises:
        GradeError: the file is not a table of grades, and must not be overwritten.
        OSError: the file is longer than ``MAX_BYTES``, or cannot be read.
    """
    if not path.exists():
        return {}
    needed = NAME, POINTS, MOST, FAILURE, CODE, RUBRIC
    return _load_rows(path, needed, "not a table of grades", _check_points, "; use another name")


def load_days(path: Path) -> dict[str, int]:
    """Return the number of days by which each listed submission is late, by name.

    Raises:
        GradeError: the file is not a CSV table with the columns ``submission`` and ``days``, or a
            number of days is not a whole number from 0 to ``MAX_DAYS``.
        OSError: the file is longer than ``MAX_BYTES``, or cannot be read.
    """
    rows = _load_rows(path, (NAME, DAYS), "not a table of late submissions", _check_days)
    return {name: int(row[DAYS]) for name, row in rows.items()}


def _load_rows(
    path: Path,
    needed: Collection[str],
    fault: str,
    check: Callable[[GradeRow], None],
    advice: str = "",
) -> dict[str, GradeRow]:
    """Return the rows of a CSV table by the name of the submission.

    The error of a bad table has the fault, the reason and the advice. It names the line of a row
    for which ``check`` raises ``ValueError``.
    """
    data = read_file(path, MAX_BYTES)
    try:
        with StringIO(data.decode("utf-8-sig"), newline="") as file:
            reader = csv.reader(file, strict=True)
            columns: list[str] = next(reader, [])
            for name in needed:
                if name not in columns:
                    raise ValueError(f"the column {name!r} is missing")
            if len(columns) > MAX_COLUMNS:
                number = f"{len(columns):,} columns"
                raise ValueError(f"{number} are more than MAX_COLUMNS = {MAX_COLUMNS}")
            rows = {}
            for fields in filter(None, reader):
                try:
                    if len(fields) != len(columns):
                        raise ValueError(f"{counted(len(fields), 'field')}, not {len(columns)}")
                    row = dict(zip(columns, fields, strict=True))
                    check(row)
                except ValueError as error:
                    raise ValueError(f"line {reader.line_num}: {error}") from None
                rows[row[NAME]] = row
            return rows
    except (ValueError, csv.Error) as error:
        raise GradeError(f"{path}: {fault}: {error}{advice}") from None


def _check_points(row: GradeRow) -> None:
    if not math.isfinite(float(row[POINTS])):
        raise ValueError(f"{POINTS} is {row[POINTS]}")


def _check_days(row: GradeRow) -> None:
    days = row[DAYS]
    if not (days.isdecimal() and len(days) < 5 and int(days) <= MAX_DAYS):
        allowed = f"a whole number from 0 to {MAX_DAYS}"
        raise ValueError(f"{DAYS} is {days[:20]!r}; allowed: {allowed}")


def save_grades(path: Path, columns: list[str], rows: Mapping[str, GradeRow]) -> None:
    """Write the table in the order of the names; after an error the old file is unchanged."""
    lines = ([rows[name].get(column, "") for column in columns] for name in sorted(rows))
    _save(path, [columns, *lines])


def save_moodle(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a grading worksheet for Moodle; after an error the old file is unchanged."""
    lines = [["Identifier", "Full name", "Grade", "Maximum Grade", "Last modified (grade)",
              "Feedback comments"]]  # fmt: skip
    for _, row in sorted(rows.items()):
        found = MOODLE.match(row[NAME])
        who = [f"Participant {found['number']}", found["name"]] if found else [_login(row), ""]
        lines.append([*who, row[POINTS], f"{rubric.points:g}", "-", row[FAILURE]])
    _save(path, lines)


def save_canvas(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a gradebook for Canvas with one assignment; after an error the old file remains."""
    lines = [["Student", "ID", "SIS User ID", "SIS Login ID", "Section", rubric.title],
             ["    Points Possible", "", "", "", "", f"{rubric.points:g}"]]  # fmt: skip
    for _, row in sorted(rows.items()):
        found = CANVAS.match(row[NAME])
        who = [found["name"], found["number"], "", ""] if found else ["", "", "", _login(row)]
        lines.append([*who, "", row[POINTS]])
    _save(path, lines)


def _login(row: GradeRow) -> str:
    return re.sub(r"\.(py|ipynb|zip)$", "", row[NAME], flags=re.IGNORECASE)


def _save(path: Path, lines: Iterable[Iterable[str]]) -> None:
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


def summary_of(rows: Collection[GradeRow], rubric: Rubric) -> list[str]:
    """Return sentences about the points of a class, and about the criterion that most miss.

    Args:
        rows: rows of the table of grades, at least one.
        rubric: rubric of the class.
    """
    points, most = [float(row[POINTS]) for row in rows], rubric.points
    full, none = sum(each >= most for each in points), sum(each == 0 for each in points)
    sentences = [
        f"mean {mean(points):.1f}, median {round(median(points), 1):g}; "
        f"all points: {full}, no points: {none}"
    ]
    missed = []
    for criterion in rubric.criteria:
        given = [float(row[criterion.name]) for row in rows]
        lacking = sum(each < criterion.points for each in given)
        if lacking:
            missed.append((lacking, -mean(given) / criterion.points, criterion.name))
    if missed:
        lacking, share, name = max(missed, key=lambda each: each[:2])
        sentences.append(
            f"most often missed: {name!r} ({lacking} of {len(rows)} submissions lack points; "
            f"{percent(-share)} of the points on average)"
        )
    return sentences
