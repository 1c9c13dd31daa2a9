"""Grade all submissions in a folder: in parallel, and only those that have changed."""

from __future__ import annotations

import json
from concurrent.futures import Future, as_completed
from pathlib import Path

from agents.errors import GradeError, WorkerError
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.grading.grades import (
    CODE,
    FAILURE,
    NAME,
    POINTS,
    RUBRIC,
    GradeRow,
    columns_of,
    failed_row,
    load_grades,
    plain,
    row_of,
    save_grades,
)
from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import GradeReport, grade
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.submissions import Submission, Unusable, in_folder
from agents.lab.grading.trust import most_jobs
from agents.lab.trials.workers import process_pool
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import counted

RESULTS, PAGE, TABLE = ".json", ".html", ".csv"


def write_report(path: Path, report: GradeReport) -> None:
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


def grade_folder(
    folder: Path,
    kind: str | None,
    rubric: Rubric,
    target: Path,
    pages: Path | None,
    user: str | None,
    jobs: int,
) -> None:
    """Grade the submissions in a folder that have changed, and write the table after each.

    Args:
        folder: folder of the submissions.
        kind: class of the agents, or ``None``.
        rubric: criteria, cases and limits.
        target: file of the table.
        pages: folder for the page and the results of each, or ``None``.
        user: user that runs agents, see ``Sandbox``.
        jobs: number of processes.
    """
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    found = list(in_folder(folder, kind))
    if not found:
        raise GradeError(f"{folder}: there is no .py file in it, nor a folder with one")
    before, rows = load_grades(target), dict[str, GradeRow]()
    waiting = list[Submission]()
    for each in found:
        if isinstance(each, Unusable):
            rows[each.name] = failed_row(each.name, each.reason, rubric)
        elif _is_done(each, before, rubric, pages):
            rows[each.name] = before[plain(each.name)]
        else:
            waiting.append(each)
    unusable = sum(isinstance(each, Unusable) for each in found)
    unchanged = len(found) - len(waiting) - unusable
    counts = f"{len(waiting)} graded, {unchanged} unchanged, {unusable} that cannot be graded"
    save_grades(target, columns_of(rubric), rows)
    try:
        with (
            process_pool(max(min(most_jobs(user, jobs), len(waiting)), 1)) as (pool, _),
            progress_bar(len(waiting), "submissions") as advance,
        ):
            futures = {pool.submit(_grade, each, rubric, user, pages): each for each in waiting}
            for number, future in enumerate(as_completed(futures), 1):
                each = futures[future]
                rows[each.name] = _row(future, each, rubric)
                save_grades(target, columns_of(rubric), rows)
                advance(number, each.name)
    except KeyboardInterrupt:
        done = f"{len(rows)} of {counted(len(found), 'submission')} are in {target}"
        say(f"{done}; run the same command again to resume")
        raise
    _print_grades(rows, rubric)
    say(f"saved {target}: {counts}")


def _is_done(
    each: Submission, before: dict[str, GradeRow], rubric: Rubric, pages: Path | None
) -> bool:
    row = before.get(plain(each.name))
    if row is None or not row.keys() >= set(columns_of(rubric)):
        return False
    if (row[CODE], row[RUBRIC]) != (each.digest, rubric.digest):
        return False
    return pages is None or all(path.exists() for path in _files(pages, each))


def _files(pages: Path, each: Submission) -> list[Path]:
    return [pages / f"{each.name}{suffix}" for suffix in (PAGE, RESULTS)]


def _grade(each: Submission, rubric: Rubric, user: str | None, pages: Path | None) -> GradeReport:
    """Grade a submission, in a process of its own."""
    report = grade(each, rubric, user)
    for path in _files(pages, each) if pages else ():
        write_report(path, report)
    return report


def _row(future: Future[GradeReport], each: Submission, rubric: Rubric) -> GradeRow:
    try:
        return row_of(each.name, future.result())
    except WorkerError as error:  # an agent has ended the grader
        return failed_row(each.name, f"it ended the grader: {error}", rubric, each.digest)


def _print_grades(rows: dict[str, GradeRow], rubric: Rubric) -> None:
    """Print the points of each submission, the best first, and why some could not be graded.

    Columns have the numbers of criteria, whose names would make the table wider than a terminal.
    """
    names = [criterion.name for criterion in rubric.criteria]
    columns = [NAME, POINTS, *(f"{number}" for number in range(1, len(names) + 1))]
    ordered = sorted(rows.values(), key=lambda row: (-float(row[POINTS]), row[NAME]))
    lines = [tuple(row[column] for column in (NAME, POINTS, *names)) for row in ordered]
    title = f"{rubric.title}: {counted(len(rows), 'submission')}, points of {rubric.points:g}"
    print_table(TextTable(tuple(columns), lines, title))
    for number, criterion in enumerate(rubric.criteria, 1):
        say(f"{number:>3}  {criterion.name}, of {criterion.points:g}")
    for row in ordered:
        if row[FAILURE]:
            say(f"{row[NAME]}: {row[FAILURE]}")
