"""Grade all submissions in a folder: in parallel, and only those that have changed."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future, as_completed
from pathlib import Path

from agents.errors import AgentError, GradeError, WorkerError
from agents.lab.commands.grade.pages import INDEX, are_written, write_files, write_index
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.grading.copies import find_copies
from agents.lab.grading.criteria import VISIBILITIES
from agents.lab.grading.grades import (
    CODE,
    FAILURE,
    LATE,
    NAME,
    POINTS,
    RUBRIC,
    SIMILAR,
    GradeRow,
    columns_of,
    failed_row,
    load_grades,
    plain,
    row_of,
    save_grades,
    summary_of,
)
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.sandbox import most_jobs
from agents.lab.grading.submissions import Submission, Unusable, in_folder
from agents.lab.trials.workers import process_pool
from warehouse_core.wording import counted

NOBODY_LATE: Mapping[str, int] = {}


def grade_folder(
    folder: Path,
    kind: str | None,
    rubric: Rubric,
    target: Path,
    pages: Path | None,
    user: str | None,
    jobs: int,
    late: Mapping[str, int] = NOBODY_LATE,
    when: str = VISIBILITIES[0],
) -> dict[str, GradeRow]:
    """Grade the submissions in a folder that have changed, and write the table after each.

    Args:
        folder: folder of the submissions.
        kind: class of the agents, or ``None``.
        rubric: criteria, cases and limits.
        target: file of the table.
        pages: folder for the page and the results of each, or ``None``.
        user: user that runs agents, see ``Sandbox``.
        jobs: number of processes.
        late: days by which submissions are late, by their names; others are not.
        when: time at which students see the pages, one of ``VISIBILITIES``.

    Returns:
        the rows of the table, by the names of the submissions.
    """
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    ours = [target, *rubric.files, rubric.starter, *([pages] if pages else [])]
    found = list(in_folder(folder, kind, ours))
    _check_names(folder, [each.name for each in found], late)
    before, rows = load_grades(target), dict[str, GradeRow]()
    waiting = list[Submission]()
    for each in found:
        days = late.get(each.name, 0)
        if isinstance(each, Unusable):
            rows[each.name] = failed_row(each.name, each.reason, rubric, late=days)
        elif _is_done(each, before, rubric, days) and (
            pages is None or are_written(pages, each, rubric, when)
        ):
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
            futures = {
                pool.submit(_grade, each, rubric, user, pages, late.get(each.name, 0), when): each
                for each in waiting
            }
            for number, future in enumerate(as_completed(futures), 1):
                each = futures[future]
                rows[each.name] = _row(future, each, rubric, late.get(each.name, 0))
                save_grades(target, columns_of(rubric), rows)
                advance(number, each.name)
    except KeyboardInterrupt:
        done = f"{len(rows)} of {counted(len(found), 'submission')} are in {target}"
        say(f"{done}; run the same command again to resume")
        raise
    alike = find_copies([each for each in found if isinstance(each, Submission)], rubric)
    for name, row in rows.items():
        rows[name] = row | {SIMILAR: plain(alike.get(name, ""))}
    save_grades(target, columns_of(rubric), rows)
    _print_grades(rows, rubric)
    if pages is not None:
        say(f"saved {write_index(pages, rows, rubric)}, the page of the class")
    say(f"saved {target}: {counts}")
    return rows


def _check_names(folder: Path, names: list[str], late: Mapping[str, int]) -> None:
    if not names:
        raise GradeError(f"{folder}: there is no submission in it")
    if INDEX in names:
        raise GradeError(f"{folder / INDEX}: the page of the class has this name; choose another")
    unknown = [name for name in late if name not in names]
    if unknown:
        raise GradeError(
            f"{folder}: no submission is called {unknown[0]!r}, which is said to be late"
        )


def _is_done(each: Submission, before: dict[str, GradeRow], rubric: Rubric, late: int = 0) -> bool:
    row = before.get(plain(each.name))
    if row is None or not row.keys() >= set(columns_of(rubric)):
        return False
    return (row[CODE], row[RUBRIC], row[LATE]) == (each.digest, rubric.digest, str(late))


def _grade(
    each: Submission, rubric: Rubric, user: str | None, pages: Path | None, late: int, when: str
) -> GradeRow:
    """Grade a submission, in a process of its own."""
    report = grade(each, rubric, user, late=late)
    if pages is not None:
        write_files(pages, each, report, when)
    return row_of(each.name, report)


def _row(future: Future[GradeRow], each: Submission, rubric: Rubric, late: int = 0) -> GradeRow:
    try:
        return future.result()
    except WorkerError as error:  # an agent has ended the grader
        return failed_row(each.name, f"it ended the grader: {error}", rubric, each.digest, late)
    except AgentError as error:  # an archive that cannot be unpacked
        return failed_row(each.name, str(error), rubric, each.digest, late)


def _print_grades(rows: dict[str, GradeRow], rubric: Rubric) -> None:
    """Print the points of each submission, the best first, why some have none, and a summary.

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
    for row in ordered:
        if row[SIMILAR]:
            say(f"{row[NAME]} is like {row[SIMILAR]}: a hint to look, and no verdict")
    for sentence in summary_of(rows.values(), rubric).sentences:
        say(sentence)
