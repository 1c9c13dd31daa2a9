"""The table of the grades of a class, its summary, and what it is for Moodle and Canvas.

The table is a CSV file with a row for each submission. Moodle and Canvas name the files that they
hand out by a number of the student, by which the row is found again; files of other names are taken
to be named like the student.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from io import StringIO
from pathlib import Path
from statistics import mean, median
from typing import NamedTuple

from agents.errors import GradeError
from agents.lab.grading.grading import Grade, GradeReport
from agents.lab.grading.rubric import MAX_DAYS, TAKEN, Rubric
from agents.lab.trials.wording import percent
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file
from warehouse_core.wording import counted, listed, printable, spreadsheet_text

NAME, POINTS, MOST, LATE, FAILURE, OUTCOMES, CODE, RUBRIC = TAKEN

DAYS = "days"
"""Column of a table of late submissions."""

MAX_BYTES, MAX_COLUMNS = 5_000_000, 1_000
"""Limits on the bytes of a table, enough for ten thousand submissions, and on its columns."""

MOODLE = re.compile(r"(?P<name>.+)_(?P<number>\d+)_assignsubmission_")
"""Folders and files that Moodle hands out: ``Full Name_123_assignsubmission_file_``."""

CANVAS = re.compile(r"(?P<name>[^_]+)_(?:LATE_)?(?P<number>\d+)_\d+_")
"""Files that Canvas hands out: ``lastfirst_LATE_123_456_agent.py``."""

PARTS = 10
"""Ranges of points, of the same width, in which submissions are counted."""

OUTCOME = re.compile(r"([\d,]+) (\D+?)(?=, \d| and \d|$)")
"""An outcome in a table of grades and how often it occurs, as ``criteria.outcomes`` writes it."""

GradeRow = dict[str, str]


def columns_of(rubric: Rubric) -> list[str]:
    """Return the columns of the table of a rubric."""
    names = (each.name for each in rubric.criteria)
    return [NAME, POINTS, MOST, *names, LATE, FAILURE, OUTCOMES, CODE, RUBRIC]


def row_of(name: str, report: GradeReport) -> GradeRow:
    """Return the row of a submission."""
    return {
        NAME: plain(name), POINTS: f"{report.points:g}", MOST: f"{report.max_points:g}",
        **{each.criterion.name: f"{each.points:g}" for each in report.grades},
        LATE: str(report.late),
        FAILURE: plain("" if report.points else "; ".join(report.remarks)),
        OUTCOMES: report.outcomes, CODE: report.code, RUBRIC: report.rubric,
    }  # fmt: skip


def failed_row(name: str, reason: str, rubric: Rubric, code: str = "", late: int = 0) -> GradeRow:
    """Return the row of a submission that was not graded: no points."""
    failed = GradeReport(
        "", "", rubric.digest, code, tuple(Grade(each, 0.0, "") for each in rubric.criteria),
        failure=reason, reason="", note="", episodes=0,
    )  # fmt: skip
    return row_of(name, failed) | {LATE: str(late)}


def plain(text: str) -> str:
    """Return text that a spreadsheet shows and does not run."""
    return spreadsheet_text(printable(text))


def load_grades(path: Path) -> dict[str, GradeRow]:
    """Return the rows of a table by the name of the submission; none without the file.

    Raises:
        GradeError: it is another file, which is not to be overwritten.
        OSError: it is longer than ``MAX_BYTES``, or cannot be read.
    """
    if not path.exists():
        return {}
    needed = (NAME, POINTS, MOST, FAILURE, CODE, RUBRIC)
    return _rows_of(path, needed, "no table of grades", _check_points, "; use another name")


def load_days(path: Path) -> dict[str, int]:
    """Return the days that submissions are late, by their names.

    Raises:
        GradeError: the file is no CSV with the columns ``submission`` and ``days``, or has a row
            without a whole number of days.
        OSError: it is longer than ``MAX_BYTES``, or cannot be read.
    """
    rows = _rows_of(path, (NAME, DAYS), "no table of late submissions", _check_days)
    return {name: int(row[DAYS]) for name, row in rows.items()}


def _rows_of(
    path: Path,
    needed: Collection[str],
    what: str,
    check: Callable[[GradeRow], None],
    advice: str = "",
) -> dict[str, GradeRow]:
    """Return the rows of a CSV file by the name of the submission.

    An error says what the file is, and names the line of a row that raises a ``ValueError``.
    """
    data = read_file(path, MAX_BYTES)
    try:
        with StringIO(data.decode("utf-8-sig"), newline="") as file:
            reader = csv.reader(file, strict=True)
            columns: list[str] = next(reader, [])
            if missing := [name for name in needed if name not in columns]:
                raise ValueError(f"the column {missing[0]!r} is missing")
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
        raise GradeError(f"{path}: it is {what}: {error}{advice}") from None


def _check_points(row: GradeRow) -> None:
    if not math.isfinite(float(row[POINTS])):
        raise ValueError(f"{POINTS} is {row[POINTS]}")


def _check_days(row: GradeRow) -> None:
    days = row[DAYS]
    if not (days.isdecimal() and len(days) < 5 and int(days) <= MAX_DAYS):
        allowed = f"a whole number from 0 to {MAX_DAYS}"
        raise ValueError(f"{DAYS} is {days[:20]!r}; allowed: {allowed}")


def save_grades(path: Path, columns: list[str], rows: Mapping[str, GradeRow]) -> None:
    """Write the table, in the order of the names; the file is complete or as it was."""
    lines = ([rows[name].get(column, "") for column in columns] for name in sorted(rows))
    _save(path, [columns, *lines])


def save_moodle(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a grading worksheet; the file is complete or as it was."""
    lines = [["Identifier", "Full name", "Grade", "Maximum Grade", "Last modified (grade)",
              "Feedback comments"]]  # fmt: skip
    for _, row in sorted(rows.items()):
        found = MOODLE.match(row[NAME])
        who = [f"Participant {found['number']}", found["name"]] if found else [_login(row), ""]
        lines.append([*who, row[POINTS], f"{rubric.points:g}", "-", row[FAILURE]])
    _save(path, lines)


def save_canvas(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a gradebook with one assignment; after an error the old file is unchanged."""
    lines = [["Student", "ID", "SIS User ID", "SIS Login ID", "Section", rubric.title],
             ["    Points Possible", "", "", "", "", f"{rubric.points:g}"]]  # fmt: skip
    for _, row in sorted(rows.items()):
        found = CANVAS.match(row[NAME])
        who = [found["name"], found["number"], "", ""] if found else ["", "", "", _login(row)]
        lines.append([*who, "", row[POINTS]])
    _save(path, lines)


def _login(row: GradeRow) -> str:
    return re.sub(r"\.(py|ipynb|zip)$", "", row[NAME])


def _save(path: Path, lines: Iterable[Iterable[str]]) -> None:
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


class Missed(NamedTuple):
    """How many submissions lack points of a criterion, and the mean share that they have of it."""

    name: str
    points: float
    submissions: int
    share: float


class ClassSummary(NamedTuple):
    """The grades of a class.

    Attributes:
        sentences: the points, the criterion that most miss, and how all episodes end.
        ranges: number of submissions in each range of points, from the lowest, with its name.
        outcomes: number of episodes with each outcome, the most frequent first.
        missed: criteria, first the one that most submissions lack points of.
    """

    sentences: list[str]
    ranges: list[tuple[str, int]]
    outcomes: list[tuple[str, int]]
    missed: list[Missed]


def summary_of(rows: Collection[GradeRow], rubric: Rubric) -> ClassSummary:
    """Return the summary of a table of grades with at least one row."""
    points, most = [float(row[POINTS]) for row in rows], rubric.points
    places = Counter(min(int(each * PARTS / most), PARTS - 1) if most else 0 for each in points)
    ranges = [f"{n * most / PARTS:g} to {(n + 1) * most / PARTS:g}" for n in range(PARTS)]
    outcomes: Counter[str] = Counter()
    for row in rows:
        for count, name in OUTCOME.findall(row[OUTCOMES]):
            outcomes[name] += int(count.replace(",", ""))
    missed = []
    for criterion in rubric.criteria:
        given = [float(row[criterion.name]) for row in rows]
        lacking = sum(each < criterion.points for each in given)
        share = mean(given) / criterion.points if criterion.points else 1.0
        missed.append(Missed(criterion.name, criterion.points, lacking, share))
    missed.sort(key=lambda each: (-each.submissions, each.share))
    full, none = sum(each >= most for each in points), sum(each == 0 for each in points)
    sentences = [
        f"mean {mean(points):.1f}, median {median(points):g}; {full} have all points, {none} none"
    ]
    if missed and (worst := missed[0]).submissions:
        sentences.append(
            f"most miss {worst.name!r}: {worst.submissions} of {len(rows)} lack points of it, and "
            f"the mean has {percent(worst.share)}"
        )
    if outcomes:
        episodes = listed(f"{count:,} {name}" for name, count in outcomes.most_common())
        sentences.append(f"{counted(outcomes.total(), 'episode')}: {episodes}")
    named = [(name, places[n]) for n, name in enumerate(ranges)]
    return ClassSummary(sentences, named, outcomes.most_common(), missed)
