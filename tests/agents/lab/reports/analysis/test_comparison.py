"""Two cases compared seed by seed."""

from pathlib import Path

import pytest
from helpers.results_files import fill, outcomes, row

from agents.lab.experiments.store import Store
from agents.lab.reports.analysis.comparison import compare

ON, OFF = {"escape": True}, {"escape": False}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "r.sqlite"


def test_two_cases_are_compared_on_the_seeds_that_both_have(path: Path) -> None:
    first = outcomes("ddddow", steps=10)
    second = [*outcomes("dddoo", steps=13), *outcomes("ddd", seed=100)]
    fill(path, [(ON, first), (OFF, second)])
    with Store(path, read_only=True) as store:
        found = compare(store, 1, 2)
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
    ("first", "second", "chance"),
    # Of n seeds that differ, a split at least as uneven has probability 2 sum C(n, k) / 2^n.
    [("d" * 10, "o" * 10, 2 / 2**10), ("d" * 9 + "o", "o" * 9 + "d", 22 / 2**10),
     ("do", "od", 1.0), ("dd", "dd", 1.0)],
)  # fmt: skip
def test_the_p_value_is_that_of_mcnemars_exact_test(
    path: Path, first: str, second: str, chance: float
) -> None:
    fill(path, [(ON, outcomes(first)), (OFF, outcomes(second))])
    with Store(path, read_only=True) as store:
        assert compare(store, 1, 2).chance == pytest.approx(chance)


def test_cases_without_a_shared_seed_are_not_compared(path: Path) -> None:
    fill(path, [(ON, outcomes("dd")), (OFF, outcomes("dd", seed=10))])
    with Store(path, read_only=True) as store:
        found = compare(store, 1, 2)
    assert (found.seeds, found.both, found.costs) == (0, 0, {})


def test_differences_are_taken_seed_by_seed(path: Path) -> None:
    """Steps differ far more between the seeds of a case than between the cases at a seed."""
    first = [row(seed, steps=10 * seed + 10) for seed in range(30)]
    second = [row(seed, steps=10 * seed + 11 + seed % 3) for seed in range(30)]
    fill(path, [(ON, first), (OFF, second)])
    with Store(path, read_only=True) as store:
        difference = compare(store, 1, 2).costs["steps"].difference
    assert difference.estimate == 2
    assert 1.6 < difference.low < 2 < difference.high < 2.4


def test_the_p_value_of_a_pair_chosen_from_many_counts_all_pairs(path: Path) -> None:
    fill(path, [(ON, outcomes("d" * 8)), (OFF, outcomes("o" * 8))])
    with Store(path, read_only=True) as store:
        assert compare(store, 1, 2).chance == pytest.approx(2 / 2**8)
        assert compare(store, 1, 2, pairs_to_choose=6).chance == pytest.approx(12 / 2**8)
        assert compare(store, 1, 2, pairs_to_choose=10**6).chance == 1
