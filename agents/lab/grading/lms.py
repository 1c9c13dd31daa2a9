"""Grades as learning management systems import them: Moodle and Canvas.

Both name the files that they hand out by a number of the student, by which the row is found again;
files of other names are taken to be named like the student.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from agents.lab.grading.grades import FAILURE, NAME, POINTS, GradeRow
from agents.lab.grading.rubric import Rubric
from warehouse_core.files.atomic import atomic_path

MOODLE = re.compile(r"(?P<name>.+)_(?P<number>\d+)_assignsubmission_")
"""Folders and files that Moodle hands out: ``Full Name_123_assignsubmission_file_``."""

CANVAS = re.compile(r"(?P<name>[^_]+)_(?:LATE_)?(?P<number>\d+)_\d+_")
"""Files that Canvas hands out: ``lastfirst_LATE_123_456_agent.py``."""


def save_moodle(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a grading worksheet; the file is complete or as it was."""
    columns = ("Identifier", "Full name", "Grade", "Maximum Grade", "Last modified (grade)",
               "Feedback comments")  # fmt: skip

    def line(row: GradeRow) -> Iterator[str]:
        found = MOODLE.match(row[NAME])
        yield f"Participant {found['number']}" if found else _stem(row)
        yield found["name"] if found else ""
        yield from (row[POINTS], f"{rubric.points:g}", "-", row[FAILURE])

    _save(path, [columns, *(tuple(line(rows[name])) for name in sorted(rows))])


def save_canvas(path: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> None:
    """Write a gradebook with one assignment; the file is complete or as it was."""
    columns = "Student", "ID", "SIS User ID", "SIS Login ID", "Section", rubric.title
    possible = "    Points Possible", "", "", "", "", f"{rubric.points:g}"

    def line(row: GradeRow) -> Iterator[str]:
        found = CANVAS.match(row[NAME])
        name, number, login = (
            (found["name"], found["number"], "") if found else ("", "", _stem(row))
        )
        yield from (name, number, "", login, "", row[POINTS])

    _save(path, [columns, possible, *(tuple(line(rows[name])) for name in sorted(rows))])


def _stem(row: GradeRow) -> str:
    return re.sub(r"\.(py|ipynb|zip)$", "", row[NAME])


def _save(path: Path, lines: Iterable[tuple[str, ...]]) -> None:
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)
