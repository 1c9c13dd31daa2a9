"""The grade of an agent as Gradescope reads it: ``/autograder/results/results.json``.

Source: gradescope-autograders.readthedocs.io/en/latest/specs, "Output format".
"""

from __future__ import annotations

from typing import Any

from agents.lab.grading.grading import Grade, GradeReport

__all__ = ["results_of"]


def results_of(report: GradeReport) -> dict[str, Any]:
    """Return the results of a report, to be written as JSON.

    The time of execution is left out, so that the same agent has the same results.

    Example:
        >>> from dataclasses import replace
        >>> from agents.lab.grading.gradescope import results_of
        >>> from agents.lab.grading.grading import grade
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> from agents.lab.grading.submissions import find_submission
        >>> rubric = load_rubric(MINI_LAB)
        >>> one = rubric.criteria[3]._replace(needs=None)
        >>> report = grade(find_submission("greedy"), replace(rubric, criteria=(one,)))
        >>> results_of(report)["score"]
        10.0
    """
    leaders = [each for each in report.grades if each.criterion.leaderboard]
    points = f"{report.agent}: {report.points:g} of {report.max_points:g} points"
    results = {
        "score": report.points,
        "output": "\n".join([report.title, points, *report.remarks]),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "extra_data": {
            "agent": report.agent,
            "rubric": report.rubric,
            "code": report.code,
            "episodes": report.episodes,
        },
        "tests": [_test(number, grade) for number, grade in enumerate(report.grades, 1)],
    }
    if leaders:
        results["leaderboard"] = [
            {
                "name": each.criterion.name,
                "value": round(each.value, 3),
                "order": "desc" if each.criterion.measure.more_is_better else "asc",
            }
            for each in leaders
        ]
    return results


def failed_results(reason: str) -> dict[str, Any]:
    """Return the results of a submission that was not graded: no points, and the reason."""
    return {
        "score": 0, "output": reason, "output_format": "text", "visibility": "visible",
        "stdout_visibility": "hidden", "tests": [],
    }  # fmt: skip


def _test(number: int, grade: Grade) -> dict[str, Any]:
    criterion = grade.criterion
    return {
        "name": criterion.name,
        "number": str(number),
        "score": grade.points,
        "max_score": criterion.points,
        "status": "passed" if grade.is_full else "failed",
        "output": "\n".join(f"{name}: {text}" for name, text in lines_of(grade)),
        "visibility": criterion.visibility,
    }


def lines_of(grade: Grade) -> list[tuple[str, str]]:
    """Return what was asked and seen, and the worst episode, each with its name."""
    lines = [
        ("asked", grade.criterion.asked),
        ("seen", grade.seen),
        ("worst", grade.worst),
        ("replay", grade.command),
    ]
    return [(name, text) for name, text in lines if text]
