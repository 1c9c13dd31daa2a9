"""Classes of submissions, good, mediocre, wrong, slow, crashing and hostile, in every form."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from time import perf_counter, sleep

from helpers.classes import write_class
from helpers.command_line import ROOT, heed_interrupts
from helpers.submissions import RUBRIC, write_rubric

from agents.lab.commands.grade.folder import grade_folder
from agents.lab.grading.grades import load_grades
from agents.lab.grading.rubric import load_rubric

PATIENT = (
    RUBRIC.replace("start_seconds = 1.0", "start_seconds = 20.0")
    .replace("answer_seconds = 0.5", "answer_seconds = 3.0")
    .replace("episode_seconds = 3.0", "episode_seconds = 20.0")
)
"""The rubric with limits that honest agents keep on a machine with other work, too."""

USER = "nobody" if os.getuid() == 0 else None


def test_all_of_a_class_have_what_they_have_earned(tmp_path: Path, measured) -> None:
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
    copies = [name for name, each in sent.items() if each.is_copy]
    assert all(rows[name]["similar"] for name in copies)
    none = sum(row["points"] == "0" for row in rows.values())
    measured(
        "submissions of a class in all forms",
        f"{len(rows)}: every grade as earned, {none} without points, each with its reason, "
        f"{len(copies)} of {len(copies)} copies pointed out",
    )


def test_a_class_is_graded_and_resumed_after_it_was_killed(tmp_path: Path, measured) -> None:
    """By the mini-lab's rubric, on two processors; killed when a third is done, and run again."""
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
        "a class of 200 by the mini-lab's rubric, two at once",
        f"{taken / 60:.1f} min with a kill and a resumption, on a machine with {load:.1f} running "
        "processes for each processor",
    )
