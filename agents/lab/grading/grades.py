"""Grades of a class: their table and summary, and files for Moodle and Canvas.

The table is a CSV file with a row for each submission. Moodle and Canvas put a number for each
student into the names of the files that they hand out, and this number identifies the student. Any
other name counts as the login of the student.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from statistics import mean, median

from agents.errors import GradeError
from agents.lab.grading.grading import Grade, GradeReport
from agents.lab.grading.rubric import MAX_DAYS, TAKEN, Rubric
from agents.lab.grading.students import CANVAS, MOODLE
from agents.lab.grading.submissions import Submission, Unusable
from agents.lab.trials.interval import percent
from warehouse_core.files.tables import number_in, read_table, whole_in, write_table
from warehouse_core.wording import printable

NAME, POINTS, MOST, LATE, FAILURE, OUTCOMES, CODE, RUBRIC = TAKEN

DAYS = "days"
"""Column of a table of late submissions."""

MAX_BYTES = 5_000_000
"""Limit on the bytes of a table, which are enough for ten thousand submissions."""

TEXTS = (NAME, FAILURE, OUTCOMES, CODE, RUBRIC)
"""Columns of a table of grades without numbers."""

GradeRow = dict[str, str]


def columns_of(rubric: Rubric) -> list[str]:
    """Return the columns of the table of grades for a rubric."""
    names = (each.name for each in rubric.criteria)
    return [NAME, POINTS, MOST, *names, LATE, FAILURE, OUTCOMES, CODE, RUBRIC]


def row_of(name: str, report: GradeReport) -> GradeRow:
    """Return the row of a graded submission."""
    return {
        NAME: printable(name), POINTS: f"{report.points:g}", MOST: f"{report.max_points:g}",
        **{each.criterion.name: f"{each.points:g}" for each in report.grades},
        LATE: str(report.late),
        FAILURE: printable("" if report.points else "; ".join(report.remarks)),
        OUTCOMES: report.outcomes, CODE: report.code, RUBRIC: report.rubric,
    }  # fmt: skip


def failed_row(each: Submission | Unusable, reason: str, rubric: Rubric) -> GradeRow:
    """Return the row of a submission that could not be graded, without points."""
    none = tuple(Grade(criterion, 0.0, "") for criterion in rubric.criteria)
    failed = GradeReport("", "", rubric.digest, each.digest, none, reason, "", 0, late=each.late)
    return row_of(each.name, failed)


def load_grades(path: Path, columns: Collection[str] = ()) -> dict[str, GradeRow]:
    """Return the rows of a table of grades by the name of the submission, or {} without a file.

    Args:
        path: file of the table.
        columns: columns whose names may differ in case, and whose numbers are rewritten.

    Raises:
        GradeError: the file is not a table of grades, and must not be overwritten.
        OSError: the file is longer than ``MAX_BYTES``, or cannot be read.
    """
    if not path.exists():
        return {}
    needed = NAME, POINTS, MOST, FAILURE, CODE, RUBRIC
    numbers = {POINTS, MOST, *columns} - {*TEXTS}

    def made(row: GradeRow) -> GradeRow:
        return row | {name: f"{number_in(row, name):g}" for name in numbers & row.keys()}

    try:
        rows = [*read_table(path, needed, MAX_BYTES, made, NAME, columns)]
    except ValueError as error:
        raise GradeError(f"{path}: not a table of grades: {error}; use another name") from None
    return {row[NAME]: row for row in rows}


def load_days(path: Path) -> dict[str, int]:
    """Return the number of days by which each listed submission is late, by name.

    Raises:
        GradeError: the file is not a table with the columns ``submission`` and ``days``, has a
            submission twice, or a number of days is not a whole number from 0 to ``MAX_DAYS``.
        OSError: the file is longer than ``MAX_BYTES``, or cannot be read.
    """

    def made(row: GradeRow) -> tuple[str, int]:
        return row[NAME], whole_in(row, DAYS, 0, MAX_DAYS)

    try:
        return dict(read_table(path, (NAME, DAYS), MAX_BYTES, made, NAME))
    except ValueError as error:
        raise GradeError(f"{path}: not a table of late submissions: {error}") from None


class GradeTable:
    """A file with a table of grades, to which no other program may write meanwhile.

    Somebody may edit it in a spreadsheet while a class is graded.

    Args:
        path: file, which need not exist; see ``load_grades``.
        columns: columns of the table.

    Attributes:
        before: rows that the file had, by the names of the submissions.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self._path, self._columns, self._state = path, columns, _state_of(path)
        self.before = load_grades(path, columns)

    def save(self, rows: Mapping[str, GradeRow]) -> None:
        """Write the table; see ``save_grades``.

        Raises:
            GradeError: the file is not as this object has read or written it.
        """
        if _state_of(self._path) != self._state:
            raise GradeError(
                f"{self._path}: another program has written or removed it meanwhile; run the same "
                "command again when no other one uses the file"
            )
        save_grades(self._path, self._columns, rows)
        self._state = _state_of(self._path)


def _state_of(path: Path) -> tuple[int, int, int] | None:
    """Return what differs after a change of a file, or ``None`` if there is no file."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return status.st_dev, status.st_ino, status.st_mtime_ns


def save_grades(path: Path, columns: Sequence[str], rows: Mapping[str, GradeRow]) -> None:
    """Write the table in the order of the names; after an error the old file is unchanged."""
    lines = ([rows[name].get(column, "") for column in columns] for name in sorted(rows))
    write_table(path, columns, lines)


def save_moodle(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a grading worksheet for Moodle; after an error the old file is unchanged."""
    columns = ("Identifier", "Full name", "Grade", "Maximum Grade", "Last modified (grade)",
               "Feedback comments")  # fmt: skip
    lines = []
    for _, row in sorted(rows.items()):
        found = MOODLE.match(row[NAME])
        who = [f"Participant {found['number']}", found["name"]] if found else [_login(row), ""]
        lines.append([*who, row[POINTS], f"{rubric.points:g}", "-", row[FAILURE]])
    write_table(path, columns, lines)


def save_canvas(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a gradebook for Canvas with one assignment; after an error the old file remains."""
    columns = "Student", "ID", "SIS User ID", "SIS Login ID", "Section", rubric.title
    lines = [["    Points Possible", "", "", "", "", f"{rubric.points:g}"]]
    for _, row in sorted(rows.items()):
        found = CANVAS.match(row[NAME])
        who = [found["name"], found["number"], "", ""] if found else ["", "", "", _login(row)]
        lines.append([*who, "", row[POINTS]])
    write_table(path, columns, lines)


def _login(row: GradeRow) -> str:
    return re.sub(r"\.(py|ipynb|zip)$", "", row[NAME], flags=re.IGNORECASE)


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
        missed.append((lacking, -mean(given) / (criterion.points or 1), criterion.name))
    lacking, share, name = max(missed, key=lambda each: each[:2])
    if lacking:
        sentences.append(
            f"most often missed: {name!r} ({lacking} of {len(rows)} submissions lack points; "
            f"{percent(-share)} of the points on average)"
        )
    return sentences
