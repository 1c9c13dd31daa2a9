"""Hostile agents in a class: each deed in each place, with and without a user of their own.

Each class has hostile agents and honest ones between them. A hostile agent goes on like an honest
one if its deed is refused, and fails if it succeeds, so that all must have all points.
"""

import os
from itertools import product
from pathlib import Path

import pytest
from helpers.attacks import DEEDS, PLACES, attacker
from helpers.submissions import GOOD, RUBRIC, running_in, write_rubric

from agents.lab.commands.grade.folder import grade_folder
from agents.lab.grading.grades import load_grades
from agents.lab.grading.rubric import load_rubric

EVERY = 10
"""Hostile agents for an honest one."""


def left_behind() -> set[str]:
    """Return what agents of this machine may leave outside of their folders."""
    shared = [Path("/proc/sysvipc", name).read_text() for name in ("shm", "msg", "sem")]
    lines = {line for text in shared for line in text.splitlines()[1:]}
    return lines | {str(path) for place in ("/tmp", "/dev/shm") for path in Path(place).iterdir()}


@pytest.mark.parametrize("user", [None, "nobody"] if os.getuid() == 0 else [None])
@pytest.mark.parametrize("jobs", [1, 2])
def test_all_have_what_they_have_earned(tmp_path, measured, user: str | None, jobs: int) -> None:
    folder, table = tmp_path / "all", tmp_path / "grades.csv"
    folder.mkdir()
    for number, (deed, place) in enumerate(product(DEEDS, PLACES)):
        name = f"{number:03d} {deed} {place.partition('(')[0]}".replace("/", " ")
        (folder / name).mkdir()
        (folder / name / "agent.py").write_text(attacker(deed, place))
        if number % EVERY == 0:
            (folder / f"{number:03d}.py").write_text(GOOD)
    rubric = load_rubric(write_rubric(tmp_path, RUBRIC.replace("episodes = 4", "episodes = 2")))
    before = left_behind()
    grade_folder(folder, None, rubric, table, None, user, jobs)
    grades = load_grades(table)
    wrong = {name: row["failure"] for name, row in grades.items() if row["points"] != "100"}
    assert not wrong
    assert not running_in(folder)
    left = {each for each in left_behind() - before if "left" in each}
    assert not left
    who = f"as {user}" if user else "as the grader's user"
    measured(
        f"hostile agents {who}, {jobs} at once",
        f"{len(DEEDS) * len(PLACES)} with {len(grades) - len(DEEDS) * len(PLACES)} honest ones: "
        "every grade as earned, nothing left",
    )
