"""Points of solutions, of starting files, and of solutions of other exercises."""

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse

from agents.lab.grading.cases import CallCase
from agents.lab.grading.criteria import MEASURES
from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import GradeReport, grade
from agents.lab.grading.rubric import SOLUTIONS, Rubric, load_rubric, own_rubrics
from agents.lab.grading.sandbox import ENDS, FAILS, LOAD, SLOW, SameProcess
from agents.lab.grading.submissions import Submission, find_submission
from agents.lab.grading.walls import FILES, enforced

_, *NAMES = own_rubrics()

AGENTS = (
    "exercise-04", "exercise-05", "exercise-06", "exercise-08", "exercise-10", "exercise-13",
    "exercise-18", "exercise-21", "exercise-23",
)  # fmt: skip
"""Exercises that ask for an agent, each more demanding than the previous one."""


def graded(source: str, folder: Path, exercise: str) -> GradeReport:
    """Return the report of a program that is graded in this process, for speed."""
    return grade(written(source, folder), load(exercise), make_runner=SameProcess)


def written(source: str, folder: Path) -> Submission:
    """Write a program to a folder of its own, because agents must not read our files."""
    file = folder / "mine.py"
    file.write_text(source, encoding="utf-8")
    return find_submission(str(file))


def load(exercise: str) -> Rubric:
    return load_rubric(own_rubrics()[exercise])


def solution(name: str) -> str:
    return (SOLUTIONS / f"{name}.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_a_solution_has_all_points_and_a_starting_file_runs_and_has_few(name, tmp_path) -> None:
    rubric = load(name)
    assert rubric.points == 100
    assert graded(solution(name), tmp_path, name).points == 100
    begun = rubric.starter.read_text(encoding="utf-8")
    start = graded(begun, tmp_path, name)
    assert start.points < 40
    failures = (ENDS, FAILS, LOAD, SLOW)
    assert not [each.seen for each in start.grades if any(kind in each.seen for kind in failures)]
    assert "Write here" in begun or begun.count('"?"') == 25


@pytest.mark.parametrize(("before", "name"), [*pairwise(AGENTS)])
def test_the_solution_of_the_exercise_before_is_not_enough(before, name, tmp_path) -> None:
    assert graded(solution(before), tmp_path, name).points < 70


def test_a_robot_that_does_not_charge_is_not_enough_where_it_has_to(tmp_path: Path) -> None:
    assert graded(solution("exercise-13"), tmp_path, "exercise-14").points < 40


@pytest.mark.parametrize("name", NAMES)
def test_no_report_gives_an_answer_away(name: str, tmp_path: Path) -> None:
    """A script that copies answers from reports into its next submission learns nothing."""
    rubric = load(name)
    called = [case for case in rubric.used_cases if isinstance(case, CallCase)]
    functions = {case.function for case in called}
    learned = dict[str, str]()
    for _ in range(3):
        table = f"LEARNED = {learned!r}\n"
        bodies = (
            f"def {each}(*given):\n"
            f"    asked = '{each}(' + ', '.join(map(repr, given)) + ')'\n"
            "    return eval(LEARNED.get(asked, '\"?\"'))\n"
            for each in functions
        )
        report = graded(table + "\n".join(bodies), tmp_path, name)
        assert report.points == 0
        said = json.dumps(results_of(report)) + str(report)
        for case in called:
            for call in case.calls:
                assert f"not {call.answer!r}" not in said
        for each in report.grades:
            for asked, answer in re.findall(r"(\w+\(.*\)) is .*?, not (.*)", each.worst):
                learned[asked] = answer
    assert not learned


def test_neither_our_agents_nor_our_solutions_are_answers(tmp_path: Path) -> None:
    ours = "from agents import ExploringAgent\nclass Mine(ExploringAgent): pass\n"
    copied = f"exec(open({str(SOLUTIONS / 'exercise-13.py')!r}).read())\n"
    for source in (ours, copied) if FILES in enforced() else (ours,):
        report = grade(written(source, tmp_path), load("exercise-13"))
        assert report.points == 0
        assert report.failure.startswith("cannot be loaded: ")
    assert all(load(name).limits.deny_imports == ("agents",) for name in NAMES)


def test_there_are_exercises_for_every_measure_that_the_mini_lab_does_not_have() -> None:
    assert [f"exercise-{number:02}" for number in range(1, 29)] == NAMES
    assert [path.stem for path in sorted(SOLUTIONS.glob("*.py"))] == NAMES
    rubrics = [load_rubric(path) for path in own_rubrics().values()]
    assert {each.kind for rubric in rubrics for each in rubric.criteria} == MEASURES.keys()


def test_an_exercise_is_begun_and_graded_by_its_name(
    warehouse: Warehouse, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = warehouse("grade", "--rubric", "exercise-02", "--write", "mine.py").out
    assert "warehouse grade mine.py --rubric exercise-02" in out
    Path("mine.py").write_text(solution("exercise-02"))
    out = warehouse("grade", "mine.py", "--rubric", "exercise-02", "--trust").out
    assert out.startswith("agents cannot")
    assert "Exercise 2: how far is it?: mine.py\n" in out
    assert out.endswith("100 of 100 points\n")
    line = refused("grade", "mine.py", "--rubric", "exercise-99")
    assert "no rubric exercise-99; allowed: a file, or exercise-01 to exercise-28" in line
