"""Grade the submissions in a folder: in parallel, and only those that have changed.

Each submission has a row in the table of grades, and optionally a page and a file of results.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from concurrent.futures import Future, as_completed
from pathlib import Path
from urllib.parse import quote

from agents.errors import AgentError, GradeError, WorkerError
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.grading.grades import (
    CODE,
    FAILURE,
    LATE,
    NAME,
    OUTCOMES,
    POINTS,
    RUBRIC,
    GradeRow,
    GradeTable,
    columns_of,
    failed_row,
    row_of,
    summary_of,
)
from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import REPLAY, Grade, GradeReport, grade
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.sandbox import LOAD, most_jobs
from agents.lab.grading.students import finder_of, students_in
from agents.lab.grading.submissions import Submission, Unusable, in_folder
from agents.lab.trials.workers import Processes
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import counted, printable

RESULTS, PAGE = ".json", ".html"

INDEX = "index"
"""Name of the page of a class, which no submission may have."""

FOR_GRADERS = (
    "This page is for graders. The page of each student is a single file, which does not link to "
    "this one."
)


def grade_folder(
    folder: Path,
    kind: str | None,
    rubric: Rubric,
    target: Path,
    pages: Path | None,
    user: str | None,
    jobs: int,
    late: Mapping[str, int] | None = None,
    other: Iterable[Path] = (),
) -> dict[str, GradeRow]:
    """Grade the submissions in a folder that have changed, and return the table of grades.

    The table is written after each submission, unless another program has changed it meanwhile.

    Args:
        folder: folder of the submissions.
        kind: name of the class in each submission; ``None`` for the only one.
        rubric: criteria, cases and limits.
        target: file of the table.
        pages: folder for pages and results, or ``None``.
        user: user that runs agents, see ``Sandbox``.
        jobs: number of processes.
        late: number of days by which each late submission is late, by the name of an entry.
        other: further files that are not submissions.

    Returns:
        rows of the table, by the names of the submissions.
    """
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    # The last resort, as every wait for an agent has a limit of its own.
    count, watchdog = most_jobs(user, jobs), rubric.most_seconds
    ours = [target, *rubric.files, rubric.starter, *([pages] if pages else []), *other]
    found = _with_days(folder, list(in_folder(folder, kind, ours)), late or {})
    columns, rows, waiting = columns_of(rubric), dict[str, GradeRow](), list[Submission]()
    table = GradeTable(target, columns)
    find = finder_of(table.before)
    for each in found:
        row = table.before.get(find(printable(each.name)) or "")
        if isinstance(each, Unusable):
            rows[each.name] = failed_row(each, each.reason, rubric)
        elif row and _is_done(each, row, rubric) and all(map(Path.exists, _files_of(pages, each))):
            rows[each.name] = {name: row[name] for name in columns} | {NAME: printable(each.name)}
        else:
            waiting.append(each)
    table.save(rows)
    try:
        with (
            Processes(max(min(count, len(waiting)), 1), watchdog) as pool,
            progress_bar(len(waiting), "submissions") as advance,
        ):
            futures = {pool.submit(_grade, each, rubric, user, pages): each for each in waiting}
            for number, future in enumerate(as_completed(futures), 1):
                each = futures[future]
                rows[each.name] = _row(future, each, rubric)
                table.save(rows)
                advance(number, each.name)
    except KeyboardInterrupt:
        done = f"{len(rows)} of {counted(len(found), 'submission')} are in {target}"
        say(f"{done}; run the same command again to resume")
        raise
    _print_grades(rows, rubric)
    if phantoms := students_in(folder, ours)[1]:
        say(f"not submissions: {printable(', '.join(phantoms))}")
    if pages is not None:
        say(f"saved {_write_index(pages, rows, rubric)}, the page of the class")
    say(f"saved {target}: {_counts(rows, [each.name for each in waiting])}")
    return rows


def _counts(rows: Mapping[str, GradeRow], graded: Collection[str]) -> str:
    """Return how many submissions have been graded, are unchanged, or have no episode."""
    none = {
        name for name, row in rows.items()
        if not row[OUTCOMES] or row[FAILURE].startswith(LOAD)
    }  # fmt: skip
    count = len(none.union(graded)) - len(none)
    return (
        f"{count} graded, {len(rows) - count - len(none)} unchanged, {len(none)} that cannot be "
        "graded"
    )


def _with_days(
    folder: Path, found: Sequence[Submission | Unusable], late: Mapping[str, int]
) -> list[Submission | Unusable]:
    """Return submissions with their days: each is as late as its latest part."""
    if not found:
        raise GradeError(f"{folder}: it contains no submissions")
    if INDEX in [each.name for each in found]:
        raise GradeError(
            f"{folder / INDEX}: no submission may have the name of the page of the class"
        )
    find = finder_of(entry for each in found for entry in each.entries)
    days_of = dict[str, int]()
    for name, days in late.items():
        entry = find(name)
        if entry is None:
            raise GradeError(f"{folder}: --late names {name!r}, but there is no such submission")
        days_of[entry] = days
    return [
        each._replace(late=max(days_of.get(entry, 0) for entry in each.entries)) for each in found
    ]


def _is_done(each: Submission, row: GradeRow, rubric: Rubric) -> bool:
    is_whole = row.keys() >= set(columns_of(rubric))
    now = each.digest, rubric.digest, str(each.late)
    return is_whole and (row[CODE], row[RUBRIC], row[LATE]) == now


def _grade(each: Submission, rubric: Rubric, user: str | None, pages: Path | None) -> GradeRow:
    """Grade a submission, write its page and results, and return its row."""
    report = grade(each, rubric, user)
    for path in _files_of(pages, each):
        write_report(path, report.shown())
    return row_of(each.name, report)


def _row(future: Future[GradeRow], each: Submission, rubric: Rubric) -> GradeRow:
    try:
        return future.result()
    except WorkerError as error:  # an agent has ended the process of the grader
        return failed_row(each, f"it ended the grader: {error}", rubric)
    except AgentError as error:  # an archive that cannot be unpacked
        return failed_row(each, str(error), rubric)


def _best_first(rows: Mapping[str, GradeRow]) -> list[GradeRow]:
    return sorted(rows.values(), key=lambda row: (-float(row[POINTS]), row[NAME]))


def _print_grades(rows: dict[str, GradeRow], rubric: Rubric) -> None:
    """Print the points of all submissions, reasons for no points, and a summary.

    The best submissions come first. Columns are headed by the numbers of the criteria, because
    their names would make the table wider than a terminal.
    """
    names = [criterion.name for criterion in rubric.criteria]
    columns = [NAME, POINTS, *(f"{number}" for number in range(1, len(names) + 1))]
    ordered = _best_first(rows)
    lines = [tuple(row[column] for column in (NAME, POINTS, *names)) for row in ordered]
    title = f"{rubric.title}: {counted(len(rows), 'submission')}, up to {rubric.points:g} points"
    print_table(TextTable(tuple(columns), lines, title))
    for number, criterion in enumerate(rubric.criteria, 1):
        say(f"{number:>3}  {criterion.name}, up to {criterion.points:g} points")
    for row in ordered:
        if row[FAILURE]:
            say(f"{row[NAME]}: {row[FAILURE]}")
    for sentence in summary_of(rows.values(), rubric):
        say(sentence)


def write_report(path: Path, report: GradeReport) -> None:
    """Write a report as a page or as results, depending on the suffix of the file.

    After an error there is no incomplete file. A page needs no other files, and the words of the
    agent are escaped on it.
    """
    if path.suffix.lower() == PAGE:
        _write_page(path, report)
    else:
        with atomic_path(path) as part:
            part.write_text(json.dumps(results_of(report), indent=2) + "\n", encoding="utf-8")


def _write_page(path: Path, report: GradeReport) -> None:
    from markupsafe import Markup

    from agents.lab.reports.page import Page, Section, write_page  # Jinja takes long to import
    from warehouse_core.viz.player import player_frame
    from warehouse_core.viz.tracks.record_track import track_of_record

    def section(grade: Grade) -> Section:
        code = Markup("<code>{}</code>")
        rows = [
            (name, code.format(printable(text)) if name == REPLAY else text)
            for name, text in grade.lines
        ]
        title = f"{grade.criterion.name}: {grade.points:g} of {grade.criterion.points:g}"
        return Section(title, [TextTable((), rows)])

    sections = [section(each) for each in report.grades]
    if (worst := report.worst) and worst.run and worst.run.episode:
        track = track_of_record(worst.run.episode)
        player = player_frame([track], title=f"Replay of the worst episode: {worst.worst}")
        note = f"{worst.criterion.name}: {worst.worst}"
        sections.append(Section("The worst episode", [Markup(player)], note))
    digests = [("rubric", report.rubric), ("code", report.code or "built-in agent")]
    sections.append(Section("Digests", [TextTable((), digests)]))
    intro = [report.agent, f"{report.title}; {report.episodes} episodes.", *report.remarks]
    write_page(path, Page(f"{report.points:g} of {report.max_points:g} points", intro, sections))


def _files_of(pages: Path | None, submission: Submission) -> list[Path]:
    """Return the files for the page and the results of a submission, if they are wanted."""
    return (
        []
        if pages is None
        else [pages / f"{submission.name}{suffix}" for suffix in (PAGE, RESULTS)]
    )


def _write_index(pages: Path, rows: Mapping[str, GradeRow], rubric: Rubric) -> Path:
    """Write the page of a class, which is for graders, and return its file."""
    from agents.lab.reports.page import Page, Section, write_page

    names = "submission", "points", "days late", "failure"
    lines = [
        (_linked(pages, row[NAME]), row[POINTS], row[LATE], row[FAILURE])
        for row in _best_first(rows)
    ]
    path = pages / f"{INDEX}{PAGE}"
    summary = [f"{line[:1].upper()}{line[1:]}." for line in summary_of(rows.values(), rubric)]
    section = Section("Submissions", [TextTable(names, lines)])
    write_page(path, Page(rubric.title, [*summary, FOR_GRADERS], [section]))
    return path


def _linked(pages: Path, name: str) -> str:
    """Return a name with a link to the page of the submission, if there is one."""
    from markupsafe import Markup

    if not (pages / f"{name}{PAGE}").exists():
        return name
    return Markup('<a href="./{}">{}</a>').format(quote(f"{name}{PAGE}"), printable(name))
