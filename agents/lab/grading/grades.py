"""The table of the grades of many submissions: a CSV file that grows by a line at a time."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

from agents.errors import GradeError
from agents.lab.grading.grading import GradeReport
from agents.lab.grading.rubric import TAKEN, Rubric
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file
from warehouse_core.wording import counted, printable, spreadsheet_text

NAME, POINTS, MOST, LATE, FAILURE, OUTCOMES, SIMILAR, CODE, RUBRIC = TAKEN

MAX_BYTES, MAX_COLUMNS = 5_000_000, 1_000
"""Limits on the bytes of a table, enough for ten thousand submissions, and on its columns."""

GradeRow = dict[str, str]


def columns_of(rubric: Rubric) -> list[str]:
    """Return the columns of the table of a rubric."""
    names = (each.name for each in rubric.criteria)
    return [NAME, POINTS, MOST, *names, LATE, FAILURE, OUTCOMES, SIMILAR, CODE, RUBRIC]


def row_of(name: str, report: GradeReport) -> GradeRow:
    """Return the line of a submission."""
    numbers = {grade.criterion.name: f"{grade.points:g}" for grade in report.grades}
    most = f"{report.max_points:g}"
    first = {NAME: plain(name), POINTS: f"{report.points:g}", MOST: most}
    last = {
        LATE: str(report.late),
        FAILURE: plain("" if report.points else "; ".join(report.remarks)),
        OUTCOMES: report.outcomes,
        SIMILAR: "",
        CODE: report.code,
        RUBRIC: report.rubric,
    }
    return first | numbers | last


def failed_row(name: str, reason: str, rubric: Rubric, code: str = "", late: int = 0) -> GradeRow:
    """Return the line of a submission that was not graded: no points."""
    numbers = {each.name: "0" for each in rubric.criteria}
    first = {NAME: plain(name), POINTS: "0", MOST: f"{rubric.points:g}"}
    last = {LATE: str(late), FAILURE: plain(reason), OUTCOMES: "", SIMILAR: ""}
    return first | numbers | last | {CODE: code, RUBRIC: rubric.digest}


def plain(text: str) -> str:
    """Return text that a spreadsheet shows and does not run."""
    return spreadsheet_text(printable(text))


def load_grades(path: Path) -> dict[str, GradeRow]:
    """Return the lines of a table by the name of the submission; none without the file.

    Raises:
        GradeError: it is another file, which is not to be overwritten.
        OSError: it is longer than ``MAX_BYTES``, or cannot be read.
    """
    if not path.exists():
        return {}
    data = read_file(path, MAX_BYTES)
    try:
        with StringIO(data.decode("utf-8"), newline="") as file:
            return {row[NAME]: row for row in _rows(csv.reader(file, strict=True))}
    except (ValueError, csv.Error) as error:
        raise GradeError(f"{path}: it is no table of grades: {error}; use another name") from None


def _rows(reader: Any) -> Iterator[GradeRow]:
    """Yield the rows of a table whose first line has the columns.

    Raises:
        ValueError: a column is missing, or a row has another number of fields, or no points.
    """
    columns: list[str] = next(reader, [])
    missing = [name for name in (NAME, POINTS, MOST, FAILURE, CODE, RUBRIC) if name not in columns]
    if missing:
        raise ValueError(f"the column {missing[0]!r} is missing")
    if len(columns) > MAX_COLUMNS:
        raise ValueError(f"{len(columns):,} columns are more than MAX_COLUMNS = {MAX_COLUMNS}")
    for fields in filter(None, reader):
        row = dict(zip(columns, fields, strict=False))
        if len(fields) != len(columns) or not math.isfinite(float(row[POINTS])):
            raise ValueError(
                f"line {reader.line_num} has {counted(len(fields), 'field')} or no points"
            )
        yield row


def save_grades(path: Path, columns: list[str], rows: Mapping[str, GradeRow]) -> None:
    """Write the table, in the order of the names; the file is complete or as it was."""
    lines: Iterable[GradeRow] = (rows[name] for name in sorted(rows))
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
