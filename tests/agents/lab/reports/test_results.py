"""Counts, shares and means over selected cases, and comparisons of two cases by seed."""

from helpers.results_files import OFF, ON, experiment_of, fleet_row, outcomes, row

from agents.lab.experiments.store import Store
from agents.lab.reports.results import FLEETS, JOULES, PER_HOUR, STEPS, SUCCESS, Results
from agents.lab.trials.interval import Interval, paired_share_interval, share_interval


def estimates(results: Results) -> list[float | None]:
    intervals = [results.interval(each) for each in results.kind.measures]
    return [interval and interval.estimate for interval in intervals]


def test_counts_shares_and_means_cover_the_selected_cases() -> None:
    cases = [
        (ON, [row(0, steps=10, needed=8), row(1, steps=30, needed=12), row(2, "wandering")]),
        (OFF, [row(0, "oscillation"), row(1, "oscillation")]),
        ({"battery": 30}, [row(0, steps=99)]),
    ]
    with experiment_of(cases) as experiment:
        first, second, both = (experiment.results(*case_ids) for case_ids in ((1,), (2,), (1, 2)))
        assert first.modes == {"delivered": 2, "wandering": 1}
        assert first.episodes == 3
        assert first.main == share_interval(2, 3)
        assert estimates(first) == [2 / 3, 20, 20, 40]
        assert list(both.modes.items()) == [("delivered", 2), ("oscillation", 2), ("wandering", 1)]
        assert estimates(both) == [0.4, 20, 20, 40]
        assert estimates(second) == [0, None, None, None]


def test_time_and_energy_are_means_over_deliveries() -> None:
    rows = [row(n, seconds=10.0 * n, joules=7.0) for n in range(1, 40)]
    rows.append(row(99, "stalled", seconds=1e9, joules=1e9))
    with experiment_of([({"backend": "physics"}, rows)]) as experiment:
        results = experiment.results(1)
        assert estimates(results)[2:] == [200, 7]
        assert results.interval(JOULES) == Interval(7.0, 7.0, 7.0)
        assert results.is_measured


def test_the_measures_of_a_fleet_are_means_of_the_episodes_that_have_them() -> None:
    rows = [
        fleet_row(0, distance=100, blocked_by_robot=60, blocked_by_wall=30, blocked_by_person=10),
        fleet_row(1, distance=0, blocked_by_robot=0, on_time=None, mean_lateness=None,
                  joules_per_delivery=None, per_hour=60.0),
    ]  # fmt: skip
    with experiment_of([({"robots": 2}, rows)], FLEETS) as experiment:
        results = experiment.results(1)
        assert estimates(results) == [120, 0.5, 4, 1, 0.3]
        assert results.main == results.interval(PER_HOUR)


def test_the_seeds_are_from_the_first_to_the_last_of_all_cases() -> None:
    cases = [(ON, outcomes("dd", seed=7)), (OFF, outcomes("ddd", seed=5))]
    with experiment_of(cases) as experiment:
        assert experiment.results(1, 2).seeds == (5, 8)
        assert experiment.results(1).seeds == (7, 8)


def test_rows_that_a_sweep_adds_later_are_not_counted() -> None:
    cases = [(ON, outcomes("dd"))]
    with experiment_of(cases) as experiment, Store(experiment.store.path) as writer:
        writer.add(1, outcomes("dd", seed=50, steps=99))
        results = experiment.results(1)
        assert (results.episodes, estimates(results)[1]) == (2, 20)


def test_two_cases_are_compared_on_the_seeds_that_both_have() -> None:
    """Steps differ far more between the seeds of a case than between cases with the same seed."""
    first = [row(seed, steps=10 * seed + 10) for seed in range(30)]
    second = [row(seed, steps=10 * seed + 11 + seed % 3) for seed in range(30)]
    lost = [row(50, "stalled", steps=999), row(51, steps=999)]
    with experiment_of([(ON, [*first, row(50, steps=1)]), (OFF, [*second, *lost])]) as experiment:
        steps = experiment.paired(STEPS, 2, 1)
        success = experiment.paired(SUCCESS, 1, 2)
    assert steps is not None
    assert steps.estimate == 2
    assert 1.6 < steps.low < 2 < steps.high < 2.4
    assert success == paired_share_interval(1, 0, 31)


def test_cases_without_a_shared_seed_are_not_compared() -> None:
    cases = [(ON, outcomes("dd")), (OFF, outcomes("dd", seed=10))]
    with experiment_of(cases) as experiment:
        assert experiment.paired(SUCCESS, 1, 2) is None
        assert experiment.paired(STEPS, 1, 2) is None
