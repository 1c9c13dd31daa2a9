"""The page of a grade: points, and for each criterion what was asked and seen."""

from __future__ import annotations

from pathlib import Path

from agents.lab.grading.grading import Report
from agents.lab.reports.page import write_template

TEMPLATE = "grade.html"


def write_page(path: Path, report: Report) -> None:
    """Write the page of a report; what comes from the agent is escaped text.

    Raises:
        OSError: the file cannot be written.
    """
    title = f"{report.points:g} of {report.max_points:g} points"
    write_template(path, TEMPLATE, title, has_players=False, report=report)
