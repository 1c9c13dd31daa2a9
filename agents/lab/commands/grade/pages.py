"""Reports as files: a page or results of one agent, and the pages of a class."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from agents.lab.grading.cases import GradedCase
from agents.lab.grading.grades import FAILURE, LATE, NAME, POINTS, SIMILAR, GradeRow, summary_of
from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import GradeReport
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.submissions import Submission
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file

RESULTS, PAGE = ".json", ".html"

INDEX = "index"
"""Name of the page of a class, which no submission can have."""

MAX_RESULTS = 1_000_000
"""Most bytes of results that are read again."""


def write_report(path: Path, report: GradeReport) -> None:
    """Write a report by the suffix of the file; the file is complete or not there.

    On a page the words of the agent are escaped text. It is one file with all that it needs.
    """
    if path.suffix.lower() == PAGE:
        _write_page(path, report)
        return
    text = json.dumps(results_of(report), indent=2, ensure_ascii=True)
    with atomic_path(path) as part:
        part.write_text(f"{text}\n", encoding="utf-8")


def _write_page(path: Path, report: GradeReport) -> None:
    from agents.lab.reports.page import player_of, write_template  # Jinja takes long to import
    from warehouse_core.viz.tracks.record_track import track_of_record

    title, player = f"{report.points:g} of {report.max_points:g} points", None
    if (worst := report.worst) is not None and worst.run is not None:
        assert isinstance(worst.run.case, GradedCase), "a call has no actions"
        track = track_of_record(worst.run.case.episode(worst.run))
        player = player_of(track, f"Replay of the worst episode: {worst.worst}")
    write_template(
        path, "grade.html", title, has_players=player is not None, report=report, player=player
    )


def files_of(pages: Path, submission: Submission) -> list[Path]:
    """Return the page and the results of a submission."""
    return [pages / f"{submission.name}{suffix}" for suffix in (PAGE, RESULTS)]


def write_files(pages: Path, submission: Submission, report: GradeReport, when: str) -> None:
    """Write the page and the results of a submission, as its student sees them at a time."""
    for path in files_of(pages, submission):
        write_report(path, report.shown(when))


def are_written(pages: Path, submission: Submission, rubric: Rubric, when: str) -> bool:
    """Return whether the page and the results of a submission are there, as seen at that time."""
    page, results = files_of(pages, submission)
    try:
        found: Any = json.loads(read_file(results, MAX_RESULTS))
        shown = {each.name for each in rubric.criteria if each.is_shown(when)}
        return page.exists() and {each["name"] for each in found["tests"]} == shown
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False


def write_index(pages: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> Path:
    """Write the page of a class, and return it; it is for who grades, and not for students."""
    from agents.lab.reports.page import write_template

    lines = [
        (_link(pages, row[NAME]), row[NAME], row[POINTS], row[LATE], row[SIMILAR], row[FAILURE])
        for row in sorted(rows.values(), key=lambda row: (-float(row[POINTS]), row[NAME]))
    ]
    path, summary = pages / f"{INDEX}{PAGE}", summary_of(rows.values(), rubric)
    write_template(
        path, "grades.html", rubric.title, has_players=False, summary=summary, lines=lines,
        most=max(1, *(count for _, count in summary.ranges)),
    )  # fmt: skip
    return path


def _link(pages: Path, name: str) -> str:
    """Return the address of the page of a submission, or "" if there is none."""
    return f"./{quote(f'{name}{PAGE}')}" if (pages / f"{name}{PAGE}").exists() else ""
