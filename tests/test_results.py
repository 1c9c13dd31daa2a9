"""What some cases come to, and how two of them differ seed by seed."""

import math
from pathlib import Path

import pytest
from results_files import fill, outcomes, row

from agents.experiments.store import Store
from agents.interval import Interval, share_interval
from agents.reports.comparison import compare
from agents.reports.results import Experiment

ON, OFF = {"escape": True}, {"escape": False}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "r.sqlite"


def test_counts_shares_and_means_are_of_the_cases_asked_for(path: Path) -> None:
    fill(
        path,
        [
            (ON, [row(0, steps=10, needed=8), row(1, steps=30, needed=12), row(2, "wandering")]),
            (OFF, [row(0, "oscillation"), row(1, "oscillation")]),
            ({"battery": 30}, [row(0, steps=99)]),
        ],
    )
    with Store(path, read_only=True) as store:
        first, both = Experiment(store).results(1), Experiment(store).results(1, 2)
        assert first.modes == {"delivered": 2, "wandering": 1}
        assert first.episodes == 3
        assert first.success == share_interval(2, 3)
        assert first.steps is not None
        assert first.steps.estimate == 20
        assert first.steps.low == 10
        assert first.needed == 10
        assert list(both.modes.items()) == [("delivered", 2), ("oscillation", 2), ("wandering", 1)]
        assert both.success.estimate == 0.4
        assert both.steps == first.steps
        assert Experiment(store).results(2).steps is None
        assert Experiment(store).results(2).needed is None


def test_time_and_energy_are_those_of_deliveries(path: Path) -> None:
    rows = [row(n, seconds=10.0 * n, joules=7.0) for n in (1, 2, 3)]
    fill(path, [({"backend": "physics"}, [*rows, row(9, "stalled", seconds=1e9, joules=1e9)])])
    with Store(path, read_only=True) as store:
        results = Experiment(store).results(1)
        assert results.seconds is not None
        assert results.seconds.estimate == 20
        assert results.joules == Interval(7.0, 7.0, 7.0)
        assert results.is_measured


@pytest.mark.parametrize("backends", [["grid"], ["grid", "physics"]])
def test_the_grids_time_and_energy_are_not_measured(path: Path, backends: list[str]) -> None:
    fill(path, [({"backend": backend}, [row(0)]) for backend in backends])
    with Store(path, read_only=True) as store:
        assert not Experiment(store).results(*store.cases()).is_measured


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
    assert (found.first, found.second) == (10, 13)
    assert found.difference == Interval(3.0, 3.0, 3.0)


@pytest.mark.parametrize(
    ("first", "second", "chance"),
    # Of n seeds that differ, as uneven a split as this or more has 2 sum C(n, k) / 2^n.
    [("d" * 10, "o" * 10, 2 / 2**10), ("d" * 9 + "o", "o" * 9 + "d", 22 / 2**10),
     ("do", "od", 1.0), ("dd", "dd", 1.0)],
)  # fmt: skip
def test_the_chance_of_a_split_is_that_of_mcnemars_exact_test(
    path: Path, first: str, second: str, chance: float
) -> None:
    fill(path, [(ON, outcomes(first)), (OFF, outcomes(second))])
    with Store(path, read_only=True) as store:
        assert compare(store, 1, 2).chance == pytest.approx(chance)


def test_where_no_seed_is_shared_nothing_is_compared(path: Path) -> None:
    fill(path, [(ON, outcomes("dd")), (OFF, outcomes("dd", seed=10))])
    with Store(path, read_only=True) as store:
        found = compare(store, 1, 2)
    assert (found.seeds, found.both, found.difference) == (0, 0, None)
    assert math.isnan(found.first)
    assert math.isnan(found.second)


def test_the_seeds_are_from_the_first_of_all_to_the_last(path: Path) -> None:
    fill(path, [(ON, outcomes("dd", seed=7)), (OFF, outcomes("ddd", seed=5))])
    with Store(path, read_only=True) as store:
        assert Experiment(store).results(1, 2).seeds == (5, 8)
        assert Experiment(store).results(1).seeds == (7, 8)
