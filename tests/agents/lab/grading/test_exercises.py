"""The exercises: what their solutions, their starting files and other solutions are graded."""

from itertools import pairwise
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse

from agents.lab.grading.criteria import MEASURES
from agents.lab.grading.exercises import SOLUTIONS, exercise_names, find_rubric
from agents.lab.grading.grading import GradeReport, grade
from agents.lab.grading.rubric import MINI_LAB, load_rubric
from agents.lab.grading.sandbox import ENDS, FAILS, LOAD, SLOW
from agents.lab.grading.submissions import find_submission

NAMES = exercise_names()

AGENTS = (
    "exercise-04", "exercise-05", "exercise-06", "exercise-08", "exercise-10", "exercise-13",
    "exercise-18", "exercise-21", "exercise-23",
)  # fmt: skip
"""Exercises that ask for an agent, each for more than the one before it."""


def graded(file: Path, exercise: str) -> GradeReport:
    return grade(find_submission(str(file)), load_rubric(find_rubric(Path(exercise))))


@pytest.mark.parametrize("name", NAMES)
def test_a_solution_has_all_points_and_a_starting_file_runs_and_has_few(name: str) -> None:
    rubric = load_rubric(find_rubric(Path(name)))
    assert rubric.points == 100
    assert graded(SOLUTIONS / f"{name}.py", name).points == 100
    start = graded(rubric.starter, name)
    assert start.points < 40
    failures = (ENDS, FAILS, LOAD, SLOW)
    assert not [each.seen for each in start.grades if any(kind in each.seen for kind in failures)]
    begun = rubric.starter.read_text(encoding="utf-8")
    assert "Write here" in begun or begun.count('"?"') == 25


@pytest.mark.parametrize(("before", "name"), [*pairwise(AGENTS)])
def test_the_solution_of_the_exercise_before_is_not_enough(before: str, name: str) -> None:
    assert graded(SOLUTIONS / f"{before}.py", name).points < 70


def test_a_robot_that_does_not_charge_is_not_enough_where_it_has_to() -> None:
    assert graded(SOLUTIONS / "exercise-13.py", "exercise-14").points < 40


def test_there_are_exercises_for_every_measure_that_the_mini_lab_does_not_have() -> None:
    assert [f"exercise-{number:02}" for number in range(1, 27)] == NAMES
    assert [path.stem for path in sorted(SOLUTIONS.glob("*.py"))] == NAMES
    rubrics = [load_rubric(path) for path in (MINI_LAB, *map(find_rubric, map(Path, NAMES)))]
    assert {each.kind for rubric in rubrics for each in rubric.criteria} == MEASURES.keys()


def test_an_exercise_is_begun_and_graded_by_its_name(
    warehouse: Warehouse, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = warehouse("grade", "--rubric", "exercise-02", "--starter", "mine.py").out
    assert "warehouse grade mine.py --rubric exercise-02" in out
    Path("mine.py").write_text((SOLUTIONS / "exercise-02.py").read_text(encoding="utf-8"))
    out = warehouse("grade", "mine.py", "--rubric", "exercise-02", "--trust").out
    assert out.startswith("agents cannot")
    assert "Exercise 2: how far is it?: mine.py\n" in out
    assert out.endswith("100 of 100 points\n")
    line = refused("grade", "mine.py", "--rubric", "exercise-99")
    assert "no rubric exercise-99; allowed: a file, or exercise-01 to exercise-26" in line
