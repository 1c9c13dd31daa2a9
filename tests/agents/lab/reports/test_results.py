"""Counts, shares and means over selected cases, and comparisons of two cases by seed."""

from pathlib import Path
from typing import Any

from helpers.results_files import OFF, ON, experiment_of, fleet_row, outcomes, row

from agents.lab.experiments.case import make_case
from agents.lab.experiments.plan import make_plan
from agents.lab.reports.results import (
    FLEETS,
    FOLDERS,
    PER_HOUR,
    STEPS,
    SUCCESS,
    Design,
    Factor,
    Results,
    described,
)
from agents.lab.trials.interval import paired_share_interval, share_interval


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


# The design of an experiment.


def design_of(**choices: Any) -> Design:
    return Design(dict(enumerate(make_plan(choices, 1, 0).cases)))


def rows_of(design: Design, name: str) -> list[tuple[str, list[Any]]]:
    [factor] = [each for each in design.factors if each.name == name]
    return [(described(row.others), [*row.cases]) for row in design.series(factor)]


def test_factors_are_the_settings_that_differ() -> None:
    design = design_of(battery=[60, 20], escape=[False, True], max_steps=70)
    assert design.factors == [Factor("escape", (True, False)), Factor("battery", (20, 60))]
    assert design.fixed["max_steps"] == 70
    assert design.fixed["memory"] == 10
    assert not {"escape", "battery", "tiles"} & design.fixed.keys()
    assert [factor.is_ordered for factor in design.factors] == [False, True]
    assert design_of().factors == []
    assert design_of().fixed["battery"] == 200


def test_values_are_in_ascending_order() -> None:
    sizes = design_of(layout="random", size=["10x10", "4x30", "9x9"]).factors
    assert sizes == [Factor("size", ("9x9", "10x10", "4x30"))]
    assert sizes[0].is_ordered
    assert not sizes[0].is_numeric
    numbers = design_of(layout="random", density=[0.3, 0, 0.1]).factors[0]
    assert numbers.values == (0.0, 0.1, 0.3)
    assert numbers.is_numeric


def test_series_vary_one_factor_and_the_default_is_first() -> None:
    design = design_of(battery=[20, 60, 200], view_radius=[5, 2])
    assert rows_of(design, "battery") == [
        ("view_radius 2", [20, 60, 200]),
        ("view_radius 5", [20, 60, 200]),
    ]
    assert rows_of(design, "view_radius")[0] == ("battery 200", [2, 5])


def test_a_setting_without_effect_matches_any_value() -> None:
    design = design_of(escape=[True, False], memory=[2, 5, 10])
    assert len(design.labels) == 4
    assert rows_of(design, "escape") == [
        ("memory 10", [True, False]),
        ("memory 2", [True, False]),
        ("memory 5", [True, False]),
    ]
    assert rows_of(design, "memory") == [("escape on", [2, 5, 10])]


def test_an_unbalanced_experiment_compares_the_cases_that_it_has() -> None:
    cases = [{"battery": 20}, {"battery": 60}, {"battery": 60, "max_steps": 90}]
    design = Design(dict(enumerate(map(make_case, cases))))
    assert rows_of(design, "battery") == [("max_steps 200", [20, 60])]
    assert rows_of(design, "max_steps") == [("battery 60", [90, 200])]


def test_folders_are_left_out_where_file_names_are_unique(tmp_path: Path) -> None:
    files = [tmp_path / "a" / "hall.txt", tmp_path / "b" / "hall.txt", tmp_path / "a" / "yard.txt"]
    for number, file in enumerate(files):
        file.parent.mkdir(exist_ok=True)
        wall = "#" * (number + 4)
        file.write_text(f"{wall}\n#P{'.' * number}D#\n{wall}")
    names = list(map(str, files))
    assert design_of(layout=["default", *names[1:]]).factors == [
        Factor(
            "layout",
            ("default (stations drawn)", "hall.txt (stations kept)", "yard.txt (stations kept)"),
        )
    ]
    [factor] = design_of(layout=names).factors
    assert factor.values == ("hall.txt", "hall.txt (version 2)", "yard.txt")
    assert FOLDERS.sub("", "ppo:/home/models/best.npz") == "ppo:best.npz"
    assert FOLDERS.sub("", "C:\\work\\robot.py:Class") == "robot.py:Class"
