"""Counts, shares and means of the episodes of selected cases."""

import sqlite3
from pathlib import Path

import pytest
from helpers.results_files import fill, outcomes, row

from agents.errors import StoreError
from agents.lab.evaluation.interval import Interval, share_interval
from agents.lab.experiments.store import Store
from agents.lab.reports.analysis.results import Deliveries, Experiment

ON, OFF = {"escape": True}, {"escape": False}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "r.sqlite"


def test_counts_shares_and_means_are_those_of_the_selected_cases(path: Path) -> None:
    fill(
        path,
        [
            (ON, [row(0, steps=10, needed=8), row(1, steps=30, needed=12), row(2, "wandering")]),
            (OFF, [row(0, "oscillation"), row(1, "oscillation")]),
            ({"battery": 30}, [row(0, steps=99)]),
        ],
    )
    with Store(path, read_only=True) as store:
        first, both = (
            Experiment(store, Deliveries).results(1),
            Experiment(store, Deliveries).results(1, 2),
        )
        assert first.modes == {"delivered": 2, "wandering": 1}
        assert first.episodes == 3
        assert first.success == share_interval(2, 3)
        assert first.steps is not None
        assert first.steps.estimate == 20
        assert not first.steps.is_known
        assert first.needed == 10
        assert list(both.modes.items()) == [("delivered", 2), ("oscillation", 2), ("wandering", 1)]
        assert both.success.estimate == 0.4
        assert both.steps == first.steps
        assert Experiment(store, Deliveries).results(2).steps is None
        assert Experiment(store, Deliveries).results(2).needed is None


def test_time_and_energy_are_those_of_deliveries(path: Path) -> None:
    rows = [row(n, seconds=10.0 * n, joules=7.0) for n in range(1, 40)]
    fill(path, [({"backend": "physics"}, [*rows, row(99, "stalled", seconds=1e9, joules=1e9)])])
    with Store(path, read_only=True) as store:
        results = Experiment(store, Deliveries).results(1)
        assert results.seconds is not None
        assert results.seconds.estimate == 200
        assert results.joules == Interval(7.0, 7.0, 7.0)
        assert results.is_measured


@pytest.mark.parametrize("backends", [["grid"], ["grid", "physics"]])
def test_time_and_energy_of_the_grid_are_not_measured(path: Path, backends: list[str]) -> None:
    fill(path, [({"backend": backend}, [row(0)]) for backend in backends])
    with Store(path, read_only=True) as store:
        assert not Experiment(store, Deliveries).results(*store.cases()).is_measured


def test_the_seeds_are_from_the_first_to_the_last_of_all_cases(path: Path) -> None:
    fill(path, [(ON, outcomes("dd", seed=7)), (OFF, outcomes("ddd", seed=5))])
    with Store(path, read_only=True) as store:
        assert Experiment(store, Deliveries).results(1, 2).seeds == (5, 8)
        assert Experiment(store, Deliveries).results(1).seeds == (7, 8)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE episodes SET mode = 'sold'",
        "UPDATE episodes SET steps = 'many'",
        "UPDATE episodes SET seconds = 'long'",
        "UPDATE episodes SET row = 1.5",
        "UPDATE episodes SET case_id = 77",
    ],
)
def test_invalid_rows_are_errors(path: Path, change: str) -> None:
    fill(path, [(ON, outcomes("dw"))])
    connection = sqlite3.connect(path)
    connection.execute(f"{change} WHERE seed = 1")
    connection.commit()
    connection.close()
    with Store(path, read_only=True) as store, pytest.raises(StoreError) as caught:
        Experiment(store, Deliveries)
    assert str(caught.value).startswith(f"{path}: the row of case ")
    assert "seed 1 is damaged" in str(caught.value)


def test_rows_that_a_sweep_adds_later_are_not_counted(path: Path) -> None:
    fill(path, [(ON, outcomes("dd"))])
    with Store(path, read_only=True) as store, Store(path) as writer:
        experiment = Experiment(store, Deliveries)
        writer.add(1, outcomes("dd", seed=50, steps=99))
        results = experiment.results(1)
        assert results.steps is not None
        assert (results.episodes, results.steps.estimate) == (2, 20)
