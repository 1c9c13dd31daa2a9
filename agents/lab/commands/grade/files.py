"""The files of a grade: a page, and results for Gradescope."""

from __future__ import annotations

import json
from pathlib import Path

from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import Report
from warehouse_core.files.atomic import atomic_path

RESULTS, PAGE, TABLE = ".json", ".html", ".csv"


def write_report(path: Path, report: Report) -> None:
    """Write a report by the suffix of the file; the file is complete or not there.

    On a page the words of the agent are escaped text.
    """
    if path.suffix.lower() == PAGE:
        from agents.lab.reports.page import write_template  # Jinja takes long to import

        title = f"{report.points:g} of {report.max_points:g} points"
        write_template(path, "grade.html", title, has_players=False, report=report)
        return
    text = json.dumps(results_of(report), indent=2, ensure_ascii=True)
    with atomic_path(path) as part:
        part.write_text(f"{text}\n", encoding="utf-8")
