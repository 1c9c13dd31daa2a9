"""Two cases compared seed by seed."""

from collections.abc import Sequence

import pytest
from helpers.results_files import OFF, ON, experiment_of, outcomes, row

from agents.lab.reports.analysis.comparison import Comparison, compare
from agents.lab.trials.rows import Row


def compared(first: Sequence[Row], second: Sequence[Row], pairs: int = 1) -> Comparison:
    with experiment_of([(ON, first), (OFF, second)]) as experiment:
        return compare(experiment.store, 1, 2, pairs)


def test_two_cases_are_compared_on_the_seeds_that_both_have() -> None:
    second = [*outcomes("dddoo", steps=13), *outcomes("ddd", seed=100)]
    found = compared(outcomes("ddddow", steps=10), second)
    assert found.changes == {
        ("delivered", "delivered"): 3,
        ("delivered", "oscillation"): 1,
        ("oscillation", "oscillation"): 1,
    }
    assert found.seeds == 5
    assert (found.only_first, found.only_second, found.both) == (1, 0, 3)
    steps, seconds, joules = found.costs.values()
    assert (steps.first, steps.second, steps.difference.estimate) == (10, 13, 3)
    assert (seconds.first, seconds.second, seconds.difference.estimate) == (10, 13, 3)
    assert (joules.first, joules.second, joules.difference.estimate) == (20, 26, 6)


@pytest.mark.parametrize(
    ("first", "second", "pairs", "chance"),
    # Of n seeds that differ, a split at least as uneven has probability 2 sum C(n, k) / 2^n.
    [("d" * 10, "o" * 10, 1, 2 / 2**10), ("d" * 9 + "o", "o" * 9 + "d", 1, 22 / 2**10),
     ("do", "od", 1, 1.0), ("dd", "dd", 1, 1.0),
     ("d" * 8, "o" * 8, 6, 12 / 2**8), ("d" * 8, "o" * 8, 10**6, 1.0)],
)  # fmt: skip
def test_the_p_value_is_that_of_mcnemars_exact_test_times_the_pairs_to_choose_from(
    first: str, second: str, pairs: int, chance: float
) -> None:
    found = compared(outcomes(first), outcomes(second), pairs)
    assert found.chance == pytest.approx(chance)


def test_cases_without_a_shared_seed_are_not_compared() -> None:
    found = compared(outcomes("dd"), outcomes("dd", seed=10))
    assert (found.seeds, found.both, found.costs) == (0, 0, {})


def test_differences_are_taken_seed_by_seed() -> None:
    """Steps differ far more between the seeds of a case than between the cases at a seed."""
    first = [row(seed, steps=10 * seed + 10) for seed in range(30)]
    second = [row(seed, steps=10 * seed + 11 + seed % 3) for seed in range(30)]
    difference = compared(first, second).costs["steps"].difference
    assert difference.estimate == 2
    assert 1.6 < difference.low < 2 < difference.high < 2.4
