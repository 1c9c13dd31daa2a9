from pathlib import Path

import pytest
from helpers.map_files import refusal

from warehouse_core import Layout, LayoutError
from warehouse_core.world import scenarios as scenarios_module
from warehouse_core.world.scenarios import Scenario, check_scenarios, load_scenarios

WAYS = "version 1\n0\thall.map\t4\t3\t1\t0\t3\t2\t3.41421\n"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "hall.map.scen"


def refused(file: Path, data: str | bytes) -> str:
    return refusal(load_scenarios, file, data)


def scenario(**changed: object) -> Scenario:
    return Scenario(0, "hall.map", 4, 3, (0, 1), (2, 3), 3.41421)._replace(**changed)


@pytest.mark.parametrize(
    "text",
    [
        WAYS.replace("\t", " "),
        WAYS.replace("\t", "  \t"),
        WAYS.replace("\n", "\r\n"),
        WAYS.replace("version 1", "\ufeffversion 1.0"),
        WAYS.replace("\n", "\n\n").rstrip("\n"),
    ],
    ids=["spaces", "both", "Windows", "1.0", "empty lines"],
)
def test_x_is_the_column_in_all_variants_of_the_format(path: Path, text: str) -> None:
    path.write_bytes(text.encode())
    assert load_scenarios(path) == [scenario()]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("0 hall.map 4 3 1 0 3 2", "column 23: 8 columns where there must be 9: bucket map width"
         " height start_x start_y goal_x goal_y optimal_length"),
        ("0 hall.map 4 3 1 0 3 2 5  6 7", "column 27: 11 columns where there must be 9"),
        ("a hall.map 4 3 1 0 3 2 5", "column 1: bucket is 'a'; it must be a whole number, at least"
         " 0"),
        ("0 hall.map 4 x 1 0 3 2 5", "column 14: height is 'x'"),
        ("0 hall.map 4 3 4 0 3 2 5", "column 16: start_x is 4; it must be less than the map's 4"),
        ("0 hall.map 4 3 1 3 3 2 5", "column 18: start_y is 3; it must be less than the map's 3"),
        ("0 hall.map 4 3 1 0 4 2 5", "column 20: goal_x is 4; it must be less than the map's 4"),
        ("0 hall.map 4 3 1 0 3 3 5", "column 22: goal_y is 3; it must be less than the map's 3"),
        ("0 hall.map 4 3 1 0 3 2 -5", "column 24: optimal_length is '-5'; it must be a number, at"
         " least 0"),
        ("0 hall.map 4 3 1 0 3 2 1e999", "column 24: optimal_length is '1e999'"),
        ("x" * 1001, "column 1001: the line is longer than MAX_LINE = 1000 bytes"),
    ],
)  # fmt: skip
def test_an_invalid_scenario_raises_with_its_place(path: Path, line: str, message: str) -> None:
    assert refused(path, f"{WAYS}\n{line}\n").startswith(f"line 4, {message}")


@pytest.mark.parametrize("first", ["", "version 2"])
def test_scenarios_of_another_version_raise(path: Path, first: str) -> None:
    message = refused(path, f"{first}\n")
    allowed = "it must be 'version 1' or 'version 1.0'"
    assert message == f"line 1, column 1: {first!r} is not allowed; {allowed}"


def test_too_many_scenarios_raise(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenarios_module, "MAX_SCENARIOS", 3)
    line = WAYS.splitlines()[1]
    path.write_text(f"version 1\n{line}\n{line}\n{line}\n")
    assert len(load_scenarios(path)) == 3
    for more in (line, ""):
        message = refused(path, f"version 1\n{line}\n{line}\n{line}\n{more}\n")
        assert message == "line 5, column 1: more than MAX_SCENARIOS = 3 lines"


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"width": 3, "height": 4}, "scenario 2 is for 4 x 3 cells where the layout has 3 x 4"),
        ({"start": (0, 0)}, "scenario 2: start row 0, column 0 is wall; it must be an open cell"),
        ({"goal": (2, 4)}, "scenario 2: goal row 2, column 4 is off the grid"),
    ],
)
def test_scenarios_of_another_map_raise(changed: dict[str, object], message: str) -> None:
    layout = Layout(["#...", "....", "...."])
    check_scenarios(layout, [scenario()])
    with pytest.raises(LayoutError) as caught:
        check_scenarios(layout, [scenario(), scenario(**changed)])
    assert str(caught.value).startswith(message)
