"""Grading of a large class, and of hostile agents among honest ones.

Each attack of a hostile agent is tried in each place, with and without a separate user for agents.
If its attack is refused, the agent continues like an honest one and must get full points. If the
attack succeeds, the agent fails. Other agents attack the channel to the grader, and other entries
of the folder are traps; each must get the points that it deserves.
"""

import os
import signal
import subprocess
import sys
from itertools import product
from pathlib import Path
from time import perf_counter, sleep

import pytest
from helpers.attacks import AGENTS, DEEDS, ENTRIES, PLACES, attacker
from helpers.command_line import ROOT, heed_interrupts
from helpers.submissions import GOOD, RUBRIC, SUBMISSIONS, nothing_left_in, write_rubric

from agents.lab.commands.grade.folder import grade_folder
from agents.lab.grading.grades import load_grades
from agents.lab.grading.rubric import load_rubric

PATIENT = (
    RUBRIC.replace("start_seconds = 1.0", "start_seconds = 20.0")
    .replace("answer_seconds = 0.5", "answer_seconds = 3.0")
    .replace("episode_seconds = 3.0", "episode_seconds = 20.0")
)
"""The rubric with limits that honest agents meet even on a busy machine."""

USER = "nobody" if os.getuid() == 0 else None

EVERY = 10
"""Number of hostile agents per honest agent."""


def write_class(folder: Path, size: int) -> set[str]:
    """Write agents that are good, bad or hostile, again and again, and return their names."""
    names = [f"{number} {name}" for number in range(size) for name in SUBMISSIONS][:size]
    for name in names:
        (folder / name).mkdir(parents=True)
        source = SUBMISSIONS[name.split()[1]].source
        (folder / name / "agent.py").write_text(source, encoding="utf-8")
    return {*names}


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
    assert after.keys() == sent
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
