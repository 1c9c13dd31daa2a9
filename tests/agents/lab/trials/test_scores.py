"""Scores of an agent, computed from its rows."""

import pytest
from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.trials.scores import MEASURES


def test_failures_count_in_all_measures_but_the_ratio_to_the_fewest_steps() -> None:
    scores = scores_of([GOOD] * 30 + [BAD] * 10)
    found = {each.column.split("\n")[0]: each.of(scores) for each in MEASURES}
    assert {name: interval and interval.estimate for name, interval in found.items()} == {
        "success": 0.75, "steps per delivery": pytest.approx((30 * 20 + 10 * 200) / 30),
        "steps / fewest": 2, "expanded": pytest.approx(27.5),
        "seconds per delivery": pytest.approx((30 * 40 + 10 * 400) / 30),
        "joules per delivery": pytest.approx((30 * 900 + 10 * 9000) / 30),
    }  # fmt: skip
    assert scores_of([BAD]).per_delivery("steps") is None
