"""The command ``warehouse grade``: agents and classes, graded with a rubric."""

from __future__ import annotations

import os
import shlex
from itertools import count
from pathlib import Path
from typing import Annotated

import typer

from agents.errors import GradeError
from agents.lab.commands.grade.folder import PAGE, RESULTS, grade_folder, write_report
from agents.lab.console import options
from agents.lab.console.options import MANY, option, writable
from agents.lab.console.terminal import say
from agents.lab.grading.grades import load_days, save_canvas, save_moodle
from agents.lab.grading.gradescope import write_autograder
from agents.lab.grading.grading import GradeReport
from agents.lab.grading.grading import grade as grade_agent
from agents.lab.grading.rubric import MINI_LAB, Rubric, find_rubric, load_rubric
from agents.lab.grading.sandbox import agents_user, check_trust
from agents.lab.grading.submissions import MAX_SOURCE, find_submission
from warehouse_core.files.atomic import atomic_path, check_suffix, check_target
from warehouse_core.files.reading import read_file

TABLE = ".csv"

CODE, ASKED, ARCHIVE = ".py", ".toml", ".zip"
"""Suffixes of the files written for a rubric: starting file, rubric and autograder."""


def grade(
    agent: Annotated[
        str,
        typer.Argument(
            metavar="AGENT",
            help="Agent as file.py:Class, or a folder of submissions: .py and .ipynb files, and "
            "folders and .zip files with one such file or with agent.py. Default for :Class: the "
            "only class with reset and act.",
            show_default=False,
        ),
    ] = "",
    rubric: Annotated[
        Path,
        option(
            "--rubric NAME|FILE",
            "Rubric: the name of an exercise, such as exercise-07, or a .toml file. Default: the "
            "rubric of the mini-lab.",
            show_default=False,
        ),
    ] = MINI_LAB,
    pages: Annotated[
        Path | None,
        option(
            "--pages FOLDER",
            "Save a page for each submission, its results, and a page of the class to this folder.",
        ),
    ] = None,
    late: Annotated[
        Path | None,
        option(
            "--late FILE",
            "Deduct points for late work, listed in a .csv file with the columns submission and "
            "days. The table [late] of the rubric has the points for each day.",
        ),
    ] = None,
    moodle: Annotated[
        Path | None,
        option("--moodle FILE", "Save the grades for Moodle as .csv.", callback=writable(TABLE)),
    ] = None,
    canvas: Annotated[
        Path | None,
        option("--canvas FILE", "Save the grades for Canvas as .csv.", callback=writable(TABLE)),
    ] = None,
    user: Annotated[
        str | None,
        option(
            "--user NAME",
            "Run agents as this user, such as nobody. Needs root. The user must be able to read "
            "the agents' files.",
        ),
    ] = None,
    trust: Annotated[
        bool,
        option(
            "--trust",
            "Run agents that you trust, even as root or on a system that cannot keep them from the "
            "files of others.",
        ),
    ] = False,
    jobs: options.Jobs = None,
    write: Annotated[
        Path | None,
        option(
            "--write FILE",
            "Write a file for a class and grade nothing: the starting file for students as .py, "
            "the rubric as .toml, or an autograder for Gradescope as .zip.",
            callback=writable(CODE, ASKED, ARCHIVE),
        ),
    ] = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} The report of an agent is saved as .html, or for Gradescope as .json, "
            f"and the grades of a folder as .csv. {options.MAY_BE_REPEATED} Default: none for an "
            "agent, grades.csv for a folder.",
            callback=writable(RESULTS, PAGE, TABLE),
            **MANY,
        ),
    ],
) -> None:
    """Grade an agent or a class with a rubric.

    For an agent, the command prints the points for each criterion, the
    requirement, the result, and a command that replays the worst episode. For
    a folder, it grades each submission. If you run the same command again, it
    continues after an interruption, and grades only what has changed.

    Each episode runs in a new process with limits on time and memory, which
    receives only observations. What an agent prints is discarded. On Linux
    6.2 or later, an agent can read only its own files and Python's, write no
    files, and use no threads, other processes or network. The first line of
    the output says which of these rules your system enforces. If agents could
    read the files of others, a folder needs --user or --trust. If you are
    root, the user nobody runs the agents where all these rules are enforced;
    elsewhere root needs one of the two options.

    Example: warehouse grade my_agent.py:Agent --save results.json
    """
    wanted = load_rubric(find_rubric(rubric))
    if write is not None:
        write_for_class(wanted, write)
        return
    if not agent:
        raise typer.BadParameter("AGENT is missing; see: warehouse grade -h")
    folder, kind = _folder_in(agent)
    user = agents_user(user, trust)
    if folder is not None:
        target, *more = save or [Path("grades.csv")]
        if more:
            raise typer.BadParameter(f"--save takes one {TABLE} file for a folder")
        check_suffix(target, [TABLE])
        check_target(target)
        if pages is not None:
            pages.mkdir(parents=True, exist_ok=True)
        say(check_trust(user, trust, are_many=True))
        days = load_days(late) if late else None
        rows = grade_folder(
            folder, kind, wanted, target, pages, user, jobs or os.cpu_count() or 1, days,
            filter(None, (late, moodle, canvas)),
        )  # fmt: skip
        for path, save_grades in ((moodle, save_moodle), (canvas, save_canvas)):
            if path is not None:
                save_grades(path, rows, wanted)
                say(f"saved {path}")
        return
    for name, value in {
        "--pages": pages, "--late": late, "--moodle": moodle, "--canvas": canvas,
    }.items():  # fmt: skip
        if value is not None:
            raise typer.BadParameter(
                f"{name} needs a folder of submissions; {agent!r} is not a folder"
            )
    for path in save:
        check_suffix(path, [RESULTS, PAGE])
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    submission, done = find_submission(agent), count(1)
    if not submission.is_built_in:
        say(check_trust(user, trust, are_many=False))
    with progress_bar(wanted.episodes, "episodes") as show:
        report = grade_agent(submission, wanted, user, lambda: show(next(done)))
    for path in save:
        write_report(path, report.shown() if path.suffix.lower() == PAGE else report)
    print_report(report)
    for path in save:
        say(f"saved {path}")


def _folder_in(agent: str) -> tuple[Path | None, str | None]:
    """Return the folder in an argument and the class of its agents, each ``None`` if missing."""
    if Path(agent).is_dir():
        return Path(agent), None
    source, _, kind = agent.rpartition(":")
    return (Path(source), kind) if source and Path(source).is_dir() else (None, None)


def write_for_class(rubric: Rubric, target: Path) -> None:
    """Write the starting file of a rubric, the rubric, or an autograder, depending on the suffix.

    An existing autograder is overwritten. Other existing files are not, because somebody may have
    edited them.
    """
    suffix = target.suffix.lower()
    if suffix == ARCHIVE:
        write_autograder(target, rubric)
        say(f"saved {target}")
        return
    source, shown = rubric.starter if suffix == CODE else rubric.file, shlex.quote(str(target))
    if not source.exists():
        raise GradeError(f"{rubric.file}: there is no starting file {source.name} next to it")
    text = read_file(source, MAX_SOURCE)
    if target.exists() and read_file(target, MAX_SOURCE) != text:
        raise GradeError(f"{target}: it exists and is not overwritten; choose another name")
    with atomic_path(target) as part:
        part.write_bytes(text)
    name = shlex.quote(rubric.shown_name)
    asked = "" if rubric.file == MINI_LAB else f" --rubric {name}"
    words = f"{shown}{asked}" if suffix == CODE else f"my_agent.py --rubric {shown}"
    say(f"saved {target}; to {'grade' if suffix == CODE else 'use'} it: warehouse grade {words}")


def print_report(report: GradeReport) -> None:
    """Print the report of an agent."""
    say(f"{report.title}: {report.agent}", bold=True)
    for remark in report.remarks:
        say(remark)
    for grade in report.grades:
        criterion = grade.criterion
        say(f"\n{grade.points:g} of {criterion.points:g}  {criterion.name}", bold=True)
        for name, text in grade.lines:
            say(f"    {name:9} {text}")
    say(f"\n{report.points:g} of {report.max_points:g} points", bold=True)
