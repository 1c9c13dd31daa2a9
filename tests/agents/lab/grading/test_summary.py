"""The summary of a class: its points, what most miss, and how episodes end."""

from pathlib import Path

import pytest
from helpers.submissions import write_rubric

from agents.lab.grading.criteria import outcomes
from agents.lab.grading.grades import OUTCOMES, POINTS, failed_row
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.runs import Run
from agents.lab.grading.summary import summary_of


def test_a_class_is_summarised(tmp_path: Path) -> None:
    rubric = load_rubric(write_rubric(tmp_path))
    runs = [
        Run(rubric.cases["chapter"], 1, 9, mode=mode)
        for mode in ["delivered"] * 3 + ["takes too long"] * 2 + ["cannot be loaded", "wandering"]
    ]
    none = failed_row("none", "no file", rubric)
    half = none | {POINTS: "49.5", "delivers": "30", "no way": "20", OUTCOMES: outcomes(runs)}
    full = none | {each.name: f"{each.points:g}" for each in rubric.criteria}
    full |= {POINTS: "100", OUTCOMES: "1000 delivered and 1 wandering"}
    found = summary_of([none, half, full], rubric)
    assert dict(found.ranges) == {
        f"{n * 10} to {n * 10 + 10}": int(n in (0, 4, 9)) for n in range(10)
    }
    assert found.outcomes == [
        ("delivered", 1003), ("takes too long", 2), ("wandering", 2), ("cannot be loaded", 1),
    ]  # fmt: skip
    assert [(each.name, each.submissions) for each in found.missed] == [
        ("protocol", 2), ("fewest", 2), ("delivers", 2), ("no way", 1),
    ]  # fmt: skip
    assert found.missed[2].share == pytest.approx(0.5)
    assert found.sentences == [
        "mean 49.8, median 49.5; 1 have all points, 1 none",
        "most miss 'protocol': 2 of 3 lack points of it, and the mean has 33%",
        "1,008 episodes: 1,003 delivered, 2 takes too long, 2 wandering and 1 cannot be loaded",
    ]
