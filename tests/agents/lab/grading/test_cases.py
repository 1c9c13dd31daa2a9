"""Rubrics that call functions: right answers, and reports of wrong ones."""

from pathlib import Path

import pytest

from agents.errors import GradeError
from agents.lab.grading.cases import is_right
from agents.lab.grading.grading import GradeReport, grade
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.submissions import find_submission

RUBRIC = """
title = "Calls"

[limits]
answer_seconds = 0.5

[cases.open]
function = "answer"
calls = [
    { arguments = [[1, 2], "a"], answer = [1.5, { "b" = [true] }] },
    { arguments = [[0, 0], ""], answer = 3 },
]

[cases.hidden]
function = "TABLE"
calls = [{ arguments = ["x", 1], answer = "secret" }]
visible = false

[[criteria]]
name = "answers"
points = 8
measure = "answered"
cases = ["open"]
full = 1
zero = 0

[[criteria]]
name = "hidden answers"
points = 2
measure = "answered"
cases = ["hidden"]
full = 1
"""
TABLE = 'TABLE = {"x": [0, "secret"]}\n'


def graded(folder: Path, source: str) -> GradeReport:
    (folder / "calls.toml").write_text(RUBRIC, encoding="utf-8")
    (folder / "mine.py").write_text(source, encoding="utf-8")
    return grade(find_submission(str(folder / "mine.py")), load_rubric(folder / "calls.toml"))


def test_cells_come_as_tuples_and_tuples_sets_and_arrays_are_answers(tmp_path: Path) -> None:
    source = """
import numpy as np
def answer(cell, word):
    assert {cell: word} == {(1, 2): "a"} or {cell} == {(0, 0)}
    return (np.float64(1.5), {"b": {True}}) if word else np.array(3)
"""
    report = graded(tmp_path, TABLE + source)
    assert (report.points, report.failure, report.episodes) == (10, "", 3)
    assert report.agent.endswith("mine.py")
    assert report.grades[0].seen == "100% of 2 calls: 2 right"


@pytest.mark.parametrize(
    ("body", "points", "worst"),
    [
        ("return 3", 6, "answer((1, 2), 'a') is 3, which is not the right answer"),
        ("return 3 if not word else 1 / 0", 6, "fails in answer((1, 2), 'a'): ZeroDivisionError"),
        ("return 3 if not word else open", 6, "an answer is of type builtin_function_or_method"),
        (
            "while word: pass\n    return 3",
            6,
            "takes too long in answer((1, 2), 'a'): no answer within 0.5 s",
        ),
        ("return 3 if not word else __import__('os')._exit(3)", 6, "exit code 3"),
    ],
)
def test_a_call_that_goes_wrong_is_told_and_the_others_count(tmp_path, body, points, worst) -> None:
    report = graded(tmp_path, f"{TABLE}def answer(cell, word):\n    {body}\n")
    assert report.points == points
    assert worst in report.grades[0].worst
    assert report.grades[0].command == report.failure == ""


def test_of_hidden_calls_neither_arguments_nor_answers_are_told(tmp_path: Path) -> None:
    report = graded(tmp_path, "TABLE = {'x': 'wrong'}\ndef answer(cell, word): return 3\n")
    assert report.grades[1].worst == "wrong (a hidden call)"
    crash = graded(tmp_path, "def TABLE(*values): raise ValueError(values)\n")
    assert crash.grades[1].worst == "fails: ValueError (a hidden call)"
    assert "there is neither a function nor a dictionary answer" in crash.grades[0].worst


@pytest.mark.parametrize(
    ("answer", "wanted", "same"),
    [
        (1, 1.0, True), (0.1 + 0.2, 0.3, True), (0.3001, 0.3, False), (True, 1, False),
        (1, True, False), ([1, [2.0]], [1.0, [2]], True), ([1], [1, 2], False), ("N", "N", True),
        ("n", "N", False), ({"a": 1}, {"a": 1.0}, True), ({"a": 1}, {"b": 1}, False),
        (None, -1, False), (float("nan"), 0, False), ([], {}, False), (10**400, 3.5, False),
        (10**400, 10**400, True),
    ],
)  # fmt: skip
def test_numbers_may_differ_a_little_and_nothing_else(answer, wanted, same) -> None:
    assert is_right(answer, wanted) == same


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('arguments = ["x", 1]', 'argument = ["x", 1]', "calls is [{"),
        ('arguments = ["x", 1]', 'arguments = "x"', "allowed: a list of calls, as in [{ arg"),
        ('answer = "secret"', "answer = 2020-01-01", "[cases.hidden]: calls is [{"),
        ('answer = "secret"', 'answer = "a"\nepisodes = 1', "calls"),
        ('calls = [{ arguments = ["x", 1], answer = "secret" }]', "", "function needs calls"),
        ('function = "TABLE"', "function = 1", "[cases.hidden]: function is 1; allowed: a name"),
        ('function = "TABLE"\n', "", "[cases.hidden]: there is no key 'calls'; allowed: layout"),
        ('measure = "answered"\ncases = ["hidden"]', 'measure = "delivered"\ncases = ["hidden"]',
         "measure is 'delivered', which judges episodes, but case 'hidden' has calls"),
    ],
)  # fmt: skip
def test_wrong_calls_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in RUBRIC
    (tmp_path / "calls.toml").write_text(RUBRIC.replace(old, new), encoding="utf-8")
    with pytest.raises(GradeError) as error:
        load_rubric(tmp_path / "calls.toml")
    assert message in str(error.value)
