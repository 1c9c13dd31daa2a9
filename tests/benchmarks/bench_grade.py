"""Grading: its speed, submissions in every form, and hostile agents among honest ones.

Each episode runs in a process of its own, which must cost less than starting Python. Each attack of
a hostile agent is tried in each place, with and without a separate user for agents. If its attack
is refused, the agent continues like an honest one and must get full points. If the attack succeeds,
the agent fails. Other agents attack the channel to the grader, and other entries of the folder are
traps; each must get the points that it deserves.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import count, islice, product
from pathlib import Path
from time import perf_counter, sleep
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import pytest
from helpers.attacks import AGENTS, DEEDS, ENTRIES, PLACES, attacker
from helpers.command_line import ROOT, heed_interrupts
from helpers.submissions import (
    GOOD,
    RUBRIC,
    SUBMISSIONS,
    notebook_of,
    nothing_left_in,
    write_rubric,
)
from helpers.timing import processor_seconds

from agents.lab.commands.grade.folder import grade_folder
from agents.lab.grading.grades import load_grades
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import MINI_LAB, load_rubric
from agents.lab.grading.sandbox import Sandbox
from agents.lab.grading.submissions import find_submission

PATIENT = (
    RUBRIC.replace("start_seconds = 1.0", "start_seconds = 20.0")
    .replace("answer_seconds = 0.5", "answer_seconds = 3.0")
    .replace("episode_seconds = 3.0", "episode_seconds = 20.0")
)
"""The rubric with limits that honest agents meet even on a busy machine."""

USER = "nobody" if os.getuid() == 0 else None

EVERY = 10
"""Number of hostile agents per honest agent."""


BEFORE, AFTER = GOOD.split("class Agent:")
NESTED = f"from helper import *\nclass Agent:{AFTER}"

Write = Callable[[Path], object]


class Sent(NamedTuple):
    """A submission: the function that writes it to a path, and the points that it deserves."""

    write: Write
    points: float


def text_of(text: str) -> Write:
    return lambda path: path.write_text(text, encoding="utf-8")


def tree_of(**files: str) -> Write:
    """Return a function that writes a folder; names have ``__`` for ``/`` and ``_`` for a dot."""

    def write(path: Path) -> None:
        for name, text in files.items():
            file = path / name.replace("__", "/").replace("_", ".")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")

    return write


def archive_of(**files: str) -> Write:
    """Return a function that writes an archive, with names as in ``tree_of``."""

    def write(path: Path) -> None:
        with ZipFile(path, "w") as archive:
            for name, text in files.items():
                archive.writestr(name.replace("__", "/").replace("_", "."), text, ZIP_DEFLATED)

    return write


FORMS = {
    "file.py": Sent(text_of(GOOD), 100),
    "other_name.py": Sent(text_of(GOOD.replace("Agent", "MyRobot")), 100),
    "cells.ipynb": Sent(text_of(notebook_of(BEFORE, f"class Agent:{AFTER}")), 100),
    "draws.ipynb": Sent(
        text_of(notebook_of("%matplotlib inline\n!pip install x", GOOD, "1 / 0")), 100
    ),
    "wrong.ipynb": Sent(text_of(notebook_of("class Agent\n")), 0),
    "none.ipynb": Sent(text_of("{}"), 0),
    "deep.ipynb": Sent(text_of("[" * 100_000), 0),
    "flat.zip": Sent(archive_of(agent_py=GOOD), 100),
    "inner.zip": Sent(archive_of(ann__src__agent_py=NESTED, ann__src__helper_py=BEFORE), 100),
    "cells.zip": Sent(archive_of(hw_ipynb=notebook_of(GOOD)), 100),
    "leaves.zip": Sent(archive_of(____src__agent_py=GOOD), 0),
    "none.zip": Sent(archive_of(notes_txt=""), 0),
    "bomb.zip": Sent(archive_of(agent_py="0" * 300_000_000), 0),
    "no_archive.zip": Sent(text_of("PK"), 0),
    "nested": Sent(tree_of(src__agent_py=NESTED, src__helper_py=BEFORE), 100),
    "notebook": Sent(tree_of(hw_ipynb=notebook_of(GOOD), notes_txt=""), 100),
    "two": Sent(tree_of(a_py=GOOD, b_py=GOOD), 0),
    "empty": Sent(tree_of(notes_txt=""), 0),
    "notes.txt": Sent(text_of("I was ill."), 0),
    "agents.java": Sent(text_of("class Agent {}"), 0),
    "link.py": Sent(lambda path: path.symlink_to(path.parent / "file.py"), 0),
}
"""Submissions by the names of their files, in addition to the folders in ``SUBMISSIONS``."""


def write_class(folder: Path, size: int) -> dict[str, Sent]:
    """Write ``size`` submissions, and return them by name."""
    folder.mkdir()
    written = dict(islice(_sent(), size))
    for name, sent in written.items():
        sent.write(folder / name)
    return written


def _sent() -> Iterator[tuple[str, Sent]]:
    """Yield names and submissions without end; each round has other names."""
    for number in count():
        start = f"{number} " if number else ""
        for name, each in SUBMISSIONS.items():
            yield f"{start}{name}", Sent(tree_of(agent_py=each.source), each.points)
        for name, sent in FORMS.items():
            yield f"{start}{name}", sent


def test_an_episode_in_its_own_process_is_faster_than_a_start_of_python(
    tmp_path, times_faster
) -> None:
    file = tmp_path / "agent.py"
    file.write_text(f"import numpy\n{GOOD}", encoding="utf-8")
    rubric = load_rubric(write_rubric(tmp_path))
    submission, case = find_submission(str(file)), rubric.cases["chapter"]
    with Sandbox(submission, rubric.limits) as sandbox:

        def ours() -> None:
            assert case.run(sandbox, 1).delivered

        def start() -> None:
            subprocess.run([sys.executable, "-c", "import numpy"], check=True)

        assert times_faster(ours, start) > 2


def test_submissions_a_minute(tmp_path, measured) -> None:
    """Measure one process with the mini-lab's rubric, from the first episode to the report."""
    file = tmp_path / "agent.py"
    file.write_text(GOOD, encoding="utf-8")
    submission, rubric = find_submission(str(file)), load_rubric(MINI_LAB)
    begin, used = perf_counter(), processor_seconds()
    report = grade(submission, rubric)
    taken, used = perf_counter() - begin, processor_seconds() - used
    episode = (
        f"{taken / report.episodes * 1000:.1f} ms, {used / report.episodes * 1000:.1f} ms of CPU "
        "time"
    )
    measured("graded agents, time per episode", episode)
    measured("graded agents, submissions per minute in one process", f"{60 / taken:.0f}")


def test_all_submissions_of_a_class_get_the_points_they_deserve(tmp_path: Path, measured) -> None:
    sent, table = write_class(tmp_path / "all", 60), tmp_path / "grades.csv"
    rubric = load_rubric(write_rubric(tmp_path, PATIENT))
    rows = grade_folder(tmp_path / "all", None, rubric, table, tmp_path, USER, 2)
    assert rows.keys() == sent.keys()
    wrong = {
        name: (row["points"], row["failure"])
        for name, row in rows.items()
        if float(row["points"]) != sent[name].points
    }
    assert not wrong
    silent = [name for name, row in rows.items() if row["points"] == "0" and not row["failure"]]
    assert not silent
    none = sum(row["points"] == "0" for row in rows.values())
    measured(
        "submissions of a class in all forms",
        f"{len(rows)} submissions: all grades are correct; {none} are without points, each with a "
        "reason",
    )


def test_a_class_is_graded_and_resumed_after_it_was_killed(tmp_path: Path, measured) -> None:
    """Grade with the mini-lab's rubric on two processors, kill after a third, and run again."""
    size, table = 200, tmp_path / "grades.csv"
    sent = write_class(tmp_path / "all", size)
    words = [
        sys.executable, "-m", "agents", "grade", "all", "--jobs", "2",
        *(["--user", USER] if USER else ["--trust"]),
    ]  # fmt: skip
    variables = os.environ | {"PYTHONPATH": str(ROOT)}
    begin = perf_counter()

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(
            words, cwd=tmp_path, env=variables, stdout=subprocess.PIPE, text=True,
            preexec_fn=heed_interrupts,
        )  # fmt: skip

    with start() as first:
        while not table.exists() or len(load_grades(table)) < size // 3:
            assert first.poll() is None
            sleep(0.2)
        before = load_grades(table)
        first.send_signal(signal.SIGKILL)
        first.communicate()
    with start() as second:
        out, _ = second.communicate()
    taken = perf_counter() - begin
    assert second.returncode == 0
    after = load_grades(table)
    assert after.keys() == sent.keys()
    assert all(after[name]["code"] == row["code"] for name, row in before.items())
    assert f"{len(before) - sum(not row['code'] for row in before.values())} unchanged" in out
    load = os.getloadavg()[2] / (os.cpu_count() or 1)
    measured(
        "a class of 200 with the mini-lab's rubric, 2 at a time",
        f"{taken / 60:.1f} min including a kill and a resumption, on a machine with {load:.1f} "
        "running processes per processor",
    )


def left_behind() -> set[str]:
    """Return the objects and files that agents may have left outside their folders."""
    shared = [Path("/proc/sysvipc", name).read_text() for name in ("shm", "msg", "sem")]
    lines = {line for text in shared for line in text.splitlines()[1:]}
    return lines | {str(path) for place in ("/tmp", "/dev/shm") for path in Path(place).iterdir()}


def write_hostile(folder: Path) -> dict[str, float]:
    """Write hostile and honest submissions, and return the points of each."""
    sources = {
        f"{deed} {place.partition('(')[0]}".replace("/", " "): (attacker(deed, place, folder), 100)
        for deed, place in product(DEEDS, PLACES)
    }
    points: dict[str, float] = {}
    for number, (name, (source, deserved)) in enumerate((sources | AGENTS).items()):
        entry = f"{number:03d} {name}"
        (folder / entry).mkdir()
        (folder / entry / "agent.py").write_text(source)
        points[entry] = deserved
        if number % EVERY == 0:
            (folder / f"{number:03d}.py").write_text(GOOD)
            points[f"{number:03d}.py"] = 100
    for name, each in ENTRIES.items():
        each.write(folder / name)
        if each.points is not None:
            points[name] = each.points
    return points


@pytest.mark.parametrize("user", dict.fromkeys((None, USER)))
@pytest.mark.parametrize("jobs", [1, 2])
def test_all_get_the_points_they_deserve_among_hostile_agents(
    tmp_path, measured, user: str | None, jobs: int
) -> None:
    folder, copies = tmp_path / "all", tmp_path / "copies"
    folder.mkdir()
    copies.mkdir()
    points, before = write_hostile(folder), left_behind()
    rubric = load_rubric(write_rubric(tmp_path, PATIENT.replace("episodes = 4", "episodes = 2")))
    with nothing_left_in(copies):
        rows = grade_folder(folder, None, rubric, tmp_path / "grades.csv", None, user, jobs)
    assert rows.keys() == points.keys()
    wrong = {
        name: (row["points"], row["failure"])
        for name, row in rows.items()
        if float(row["points"]) != points[name]
    }
    assert not wrong
    left = {each for each in left_behind() - before if "left" in each}
    assert not left
    honest = sum(name[3:] == ".py" for name in points)
    who = f"as {user}" if user else "as the grader's user"
    measured(
        f"hostile agents run {who}, {jobs} at a time",
        f"{len(points) - honest} hostile and {honest} honest submissions: all grades are correct, "
        "nothing is left behind",
    )
