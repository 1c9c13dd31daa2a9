"""The table of the grades of many submissions: a CSV file that grows by a line at a time."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

from agents.errors import GradeError
from agents.lab.grading.grading import GradeReport
from agents.lab.grading.rubric import Rubric
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import printable, spreadsheet_text

NAME, POINTS, MOST, FAILURE, CODE, RUBRIC = (
    "submission", "points", "of", "failure", "code", "rubric",
)  # fmt: skip

GradeRow = dict[str, str]


def columns_of(rubric: Rubric) -> list[str]:
    """Return the columns of the table of a rubric."""
    return [NAME, POINTS, MOST, *(each.name for each in rubric.criteria), FAILURE, CODE, RUBRIC]


def row_of(name: str, report: GradeReport) -> GradeRow:
    """Return the line of a submission."""
    numbers = {grade.criterion.name: f"{grade.points:g}" for grade in report.grades}
    most = f"{report.max_points:g}"
    first = {NAME: plain(name), POINTS: f"{report.points:g}", MOST: most}
    last = {
        FAILURE: plain("; ".join(report.remarks) if report.failure else ""),
        CODE: report.code,
        RUBRIC: report.rubric,
    }
    return first | numbers | last


def failed_row(name: str, reason: str, rubric: Rubric, code: str = "") -> GradeRow:
    """Return the line of a submission that was not graded: no points."""
    numbers = {each.name: "0" for each in rubric.criteria}
    first = {NAME: plain(name), POINTS: "0", MOST: f"{rubric.points:g}"}
    return first | numbers | {FAILURE: plain(reason), CODE: code, RUBRIC: rubric.digest}


def plain(text: str) -> str:
    """Return text that a spreadsheet shows and does not run."""
    return spreadsheet_text(printable(text))


def load_grades(path: Path) -> dict[str, GradeRow]:
    """Return the lines of a table by the name of the submission; none without the file.

    Another file is a ``GradeError``, so that it is not overwritten.
    """
    if not path.exists():
        return {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file, strict=True)
            rows = [dict(row) for row in reader]
            columns = reader.fieldnames or []
    except (UnicodeDecodeError, csv.Error) as error:
        raise GradeError(f"{path}: it is no table of grades: {error}") from None
    if not {NAME, POINTS, CODE, RUBRIC} <= set(columns):
        raise GradeError(
            f"{path}: it is no table of grades, as its columns are not those; use another name"
        )
    return {row[NAME]: row for row in rows}


def save_grades(path: Path, columns: list[str], rows: Mapping[str, GradeRow]) -> None:
    """Write the table, in the order of the names; the file is complete or as it was."""
    lines: Iterable[GradeRow] = (rows[name] for name in sorted(rows))
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)
