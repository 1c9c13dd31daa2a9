"""Rubrics: errors, points and digests."""

from dataclasses import fields
from pathlib import Path

import pytest
from helpers.submissions import RUBRIC, write_rubric

from agents.errors import GradeError
from agents.lab.grading.cases import GradedCase
from agents.lab.grading.criteria import MEASURES, Criterion
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import CASE, LIMITS, MINI_LAB, LateRule, load_rubric
from agents.lab.grading.sandbox import AgentLimits
from agents.lab.grading.submissions import find_submission


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("memory_mb = 512", f"memory_mb = {'9' * 1900}", "[limits]: memory_mb is 99999"),
        ("[limits]", "a" + ".a" * 10 + " = 1", "line 4 has a key of more than MAX_DEPTH = 10"),
        ("[limits]", "[limits", "it is not TOML: Expected ']' at the end of a table declaration"),
        ("[limits]", "[limit]", "there is no key 'limit'; allowed: title, limits"),
        ('title = "A short rubric"', "title = 1", "rubric.toml: title is 1; allowed: a name of at"),
        ("memory_mb = 512", "memory = 512", "[limits]: there is no key 'memory'; allowed: start"),
        ("episodes = 4", "episodes = 0", "[cases.chapter]: episodes is 0; allowed: a"),
        ("episodes = 4", "size = [7, 9]", '[cases.chapter]: size needs layout = "random"'),
        ("episodes = 4", "start = [0, 0]", "[cases.chapter]: layout: start_pos row 0, column 0"),
        ("episodes = 4", "stations = 1", "stations is 1; allowed: drawn, kept"),
        ('layout = "trap"', 'layout = "tra"', "layout: no layout is called 'tra'"),
        ('layout = "trap"', f'layout = "{400 * "x"}.txt"', "layout: [Errno 36] File name too long"),
        ('measure = "protocol"', 'measure = "x"', "measure is 'x'; allowed: delivered, steps_of_"),
        ('cases = ["closed"]', 'cases = ["open"]', "cases has 'open'; allowed: chapter, loops"),
        ('name = "stays calm"', 'name = "delivers"', "name is 'delivers', which an earlier"),
        ("points = 20\n", "", "criterion 2 has no points; needed: name, points, measure, cases"),
        ("full = 1.5", "full = 4", "full is 4 and zero is 3; for this measure full must be"),
        ('needs = "delivers"', 'needs = "fewest"', "needs is 'fewest'; allowed: delivers"),
        ('layout = "trap"', 'layout = "bare.txt"\nstations = "kept"', "there is no dropoff"),
        ("[[criteria]]", "[[criterion]]", "there is no key 'criterion'"),
    ],
)  # fmt: skip
def test_a_wrong_rubric_is_refused_with_the_table_the_key_and_what_is_allowed(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in RUBRIC
    (tmp_path / "bare.txt").write_text("P....", encoding="utf-8")
    file = write_rubric(tmp_path, RUBRIC.replace(old, new))
    with pytest.raises(GradeError) as error:
        load_rubric(file)
    assert str(error.value).startswith(str(file))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_criterion_without_any_episode_is_refused(tmp_path: Path) -> None:
    rubric = RUBRIC.replace('cases = ["closed"]', 'cases = ["loops"]')
    with pytest.raises(
        GradeError, match="'stays calm': none of its cases has an episode in which delivery is imp"
    ):
        grade(find_submission("reflex"), load_rubric(write_rubric(tmp_path, rubric)))


@pytest.mark.parametrize(
    ("kind", "full", "zero", "points"),
    [
        ("delivered", 1.0, 0.5, {0.0: 0, 0.5: 0, 0.75: 5, 0.9999999: 9.99, 1.0: 10}),
        ("delivered", 0.9, 0.9, {0.89: 0, 0.9: 10, 1.0: 10}),
        ("steps_of_fewest", 1.0, 3.0, {0.9: 10, 1.0: 10, 1.5: 7.5, 3.0: 0, 9.0: 0}),
        ("answer_seconds", 0.1, 0.1, {0.1: 10, 0.11: 0}),
    ],
)
def test_points_grow_evenly_from_zero_to_full(kind, full, zero, points) -> None:
    criterion = Criterion("a criterion", 10, kind, ("cases",), full, zero)
    assert {value: criterion.points_for(value) for value in points} == points


def test_every_key_of_a_rubric_is_checked() -> None:
    assert CASE.keys() == {field.name for field in fields(GradedCase)} - {"name"}
    assert LIMITS.keys() == set(AgentLimits._fields)


def test_the_digest_of_a_rubric_has_that_of_its_layouts(tmp_path: Path) -> None:
    layout, text = tmp_path / "hall.txt", RUBRIC.replace('layout = "trap"', 'layout = "hall.txt"')
    digests = set()
    for rows in ("P..D", "P...D"):
        layout.write_text(rows, encoding="utf-8")
        digests.add(load_rubric(write_rubric(tmp_path, text)).digest)
    assert len(digests) == 2


def test_the_rubric_of_the_mini_lab_has_100_points_and_names_every_measure() -> None:
    rubric = load_rubric(MINI_LAB)
    assert rubric.points == 100
    text = MINI_LAB.read_text(encoding="utf-8")
    assert all(f"#   {name} " in text for name in MEASURES)


def test_each_day_costs_points_and_after_the_last_day_none_are_left() -> None:
    rule = LateRule(points=10, days=2)
    assert [rule.deducted(days, 75) for days in range(4)] == [0, 10, 20, 75]
    assert rule.deducted(2, 15) == 15
    assert LateRule().deducted(9, 75) == 0
