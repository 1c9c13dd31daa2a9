"""The settings that differ between cases, and the cases that can be compared."""

from pathlib import Path
from typing import Any

from agents.lab.experiments.case import make_case
from agents.lab.experiments.plan import make_plan
from agents.lab.reports.results import FOLDERS, Design, Factor, described, make_design


def design_of(**choices: Any) -> Design:
    return make_design(dict(enumerate(make_plan(choices, 1, 0).cases)))


def rows_of(design: Design, name: str) -> list[tuple[str, list[Any]]]:
    [factor] = [each for each in design.factors if each.name == name]
    return [(described(row.others), [*row.cases]) for row in design.series(factor)]


def test_factors_are_the_settings_that_differ() -> None:
    design = design_of(battery=[60, 20], escape=[False, True], max_steps=70)
    assert design.factors == (Factor("escape", (True, False)), Factor("battery", (20, 60)))
    assert design.fixed["max_steps"] == 70
    assert design.fixed["memory"] == 10
    assert not {"escape", "battery", "tiles"} & design.fixed.keys()
    assert [factor.is_ordered for factor in design.factors] == [False, True]
    assert design_of().factors == ()
    assert design_of().fixed["battery"] == 200


def test_values_are_in_ascending_order() -> None:
    sizes = design_of(layout="random", size=["10x10", "4x30", "9x9"]).factors
    assert sizes == (Factor("size", ("9x9", "10x10", "4x30")),)
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
    design = make_design(dict(enumerate(map(make_case, cases))))
    assert rows_of(design, "battery") == [("max_steps 200", [20, 60])]
    assert rows_of(design, "max_steps") == [("battery 60", [90, 200])]


def test_files_of_the_same_name_with_different_contents_are_distinguished(tmp_path: Path) -> None:
    file = tmp_path / "hall.txt"
    cases = {}
    for number, rows in enumerate(["#####\n#P.D#\n#####", "#####\n#D.P#\n#####"]):
        file.write_text(rows)
        cases[number] = make_case({"layout": str(file)})
    [factor] = make_design(cases).factors
    assert factor.name == "layout"
    assert len(set(factor.values)) == 2
    assert all(str(value).startswith("hall.txt (") for value in factor.values)


def test_agents_of_one_name_and_different_code_are_distinguished() -> None:
    codes: list[dict[str, str]] = [{}, {"fingerprint": "0" * 64}, {"fingerprint": "1" * 64}]
    cases = {n: {**make_case({}), "agent": "mine.py:Mine", **code} for n, code in enumerate(codes)}
    [factor] = make_design(cases).factors
    assert factor.name == "agent"
    assert len(set(factor.values)) == 3
    assert all(str(value).startswith("mine.py:Mine (") for value in factor.values)


def test_folders_are_left_out_where_file_names_are_unique(tmp_path: Path) -> None:
    files = [tmp_path / "a" / "hall.txt", tmp_path / "b" / "hall.txt", tmp_path / "a" / "yard.txt"]
    for number, file in enumerate(files):
        file.parent.mkdir(exist_ok=True)
        wall = "#" * (number + 4)
        file.write_text(f"{wall}\n#P{'.' * number}D#\n{wall}")
    names = list(map(str, files))
    assert design_of(layout=["default", *names[1:]]).factors == (
        Factor(
            "layout",
            ("default (stations drawn)", "hall.txt (stations kept)", "yard.txt (stations kept)"),
        ),
    )
    [factor] = design_of(layout=names).factors
    assert [str(value)[:9] for value in factor.values] == ["hall.txt ", "hall.txt ", "yard.txt"]
    assert FOLDERS.sub("", "ppo:/home/models/best.npz") == "ppo:best.npz"
    assert FOLDERS.sub("", "C:\\work\\robot.py:Class") == "robot.py:Class"


def test_stations_are_a_factor_if_a_layout_is_used_with_both_settings(tmp_path: Path) -> None:
    file = tmp_path / "hall.txt"
    file.write_text("#######\n#P...D#\n#######")
    drawn = [{"layout": str(file), "stations": "drawn"}, {"stations": "drawn"}]
    design = make_design(dict(enumerate(map(make_case, [{"layout": str(file)}, *drawn]))))
    assert rows_of(design, "layout") == [("stations drawn", ["hall.txt", "default"])]
    assert rows_of(design, "stations") == [("layout hall.txt", ["kept", "drawn"])]
