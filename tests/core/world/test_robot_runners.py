import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.map_files import refusal

from warehouse_core import Layout, LayoutError
from warehouse_core.world import robot_runners
from warehouse_core.world.robot_runners import Delays, load_agents, load_league, load_tasks

LAYOUT = Layout(["...", "#.."])
"""The wall is location 3."""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "hall.tasks"


def refused(file: Path, data: str, load: Callable[..., Any] = load_tasks) -> str:
    return refusal(lambda path: load(path, LAYOUT), file, data)


def test_a_location_counts_the_cells_row_by_row(file: Path) -> None:
    file.write_text("3\n2,4\n5\n0,1,0\n")
    assert load_tasks(file, LAYOUT) == [((0, 2), (1, 1)), ((1, 2),), ((0, 0), (0, 1), (0, 0))]
    file.write_text("2\n4\n2\n")
    assert load_agents(file, LAYOUT) == [(1, 1), (0, 2)]


@pytest.mark.parametrize(
    "text",
    [
        "2\n2,4\n5\n",
        "# version for LoRR 2026\n2\n2,4\n# the last\n5",
        "\ufeff2\r\n2, 4\r\n5\r\n\r\n",
        "\n2\n\n2 ,4  \n5\n# the end\n\n",
    ],
    ids=["plain", "comments", "Windows", "empty lines"],
)
def test_variants_of_the_format_are_read(file: Path, text: str) -> None:
    file.write_bytes(text.encode())
    assert load_tasks(file, LAYOUT) == [((0, 2), (1, 1)), ((1, 2),)]


def test_a_file_of_no_robots_is_read(file: Path) -> None:
    file.write_text("0\n")
    assert load_agents(file, LAYOUT) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1, column 1: number of tasks is ''; it must be a whole number, at least 0"),
        ("# 1\n-1\n", "line 2, column 1: number of tasks is '-1'; it must be"),
        ("3\n1\n# 2\n2\n", "line 5, column 1: the file ends here; its number of tasks is 3"),
        ("1\n1\n\n2\n", "line 4, column 1: the file goes on here; its number of tasks is 1"),
        ("1\n1, x\n", "line 2, column 4: location is 'x'; it must be a whole number, at least 0"),
        ("1\n1,\n", "line 2, column 3: location is ''; it must be"),
        ("1\n1 2\n", "line 2, column 1: location is '1 2'; it must be"),
        ("1\n0,1,3\n", "line 2, column 5: location 3, row 1, column 0 is wall; it must be an open"),
        ("1\n6\n", "line 2, column 1: location 6, row 2, column 0 is off the grid"),
        ("1\n" + "1," * 501, "line 2, column 1001: the line is longer than MAX_LINE = 1000 bytes"),
    ],
)  # fmt: skip
def test_an_invalid_file_raises_with_the_place(file: Path, text: str, message: str) -> None:
    assert refused(file, text).startswith(message)


def test_a_robot_has_one_start(file: Path) -> None:
    message = "line 2, column 1: 2 locations where there must be 1"
    assert refused(file, "1\n1,2\n", load_agents) == message
    message = refused(file, "2\n1\n", load_agents)
    assert message == "line 3, column 1: the file ends here; its number of robots is 2"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("4\nno location\n", "line 1, column 1: 4 tasks are more than MAX_LOCATIONS = 3"),
        ("2\n1,2\n1,2\nx\n", "line 3, column 1: 4 locations are more than MAX_LOCATIONS = 3"),
        (5 * "#\n" + "\n", "line 6, column 1: more than MAX_LINES = 5 lines"),
    ],
    ids=["tasks", "locations", "lines"],
)
def test_too_many_of_anything_raise_before_the_rest_is_read(
    file: Path, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    monkeypatch.setattr(robot_runners, "MAX_LOCATIONS", 3)
    monkeypatch.setattr(robot_runners, "MAX_LINES", 5)
    assert refused(file, text) == message


PROBLEM = {
    "mapFile": "maps/hall.map",
    "agentFile": "hall.agents",
    "taskFile": "hall.tasks",
    "teamSize": 2,
    "numTasksReveal": 1.5,
}


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    """Return where the JSON of a problem goes; the files that it names are there."""
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "hall.map").write_text("type octile\nheight 2\nwidth 3\nmap\n.ES\n@..\n")
    (tmp_path / "hall.agents").write_text("3\n4\n2\n5\n")
    (tmp_path / "hall.tasks").write_text("2\n2,4\n5\n")
    return tmp_path / "hall.json"


def test_a_problem_is_read_with_the_files_that_it_names(problem: Path) -> None:
    problem.write_text(json.dumps(PROBLEM))
    layout, starts, tasks, revealed, *of_year = load_league(problem)
    assert layout == LAYOUT
    assert of_year == ["", 2024, 1, 1.0, None]
    assert (starts, tasks, revealed) == ([(1, 1), (0, 2)], [((0, 2), (1, 1)), ((1, 2),)], 3)
    problem.write_text(json.dumps({key: PROBLEM[key] for key in PROBLEM if key[:3] != "num"}))
    assert load_league(problem).revealed == 2


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"agentShape": 3, "battery": {}}, "'agentShape', 'battery'"),
        ({"x" * 90_000: 1}, f"'{'x' * 12}...{'x' * 13}'"),
        (dict.fromkeys("zyxwvutsrqpo", 0), f"{', '.join(map(repr, 'opqrstuvwx'))}, ..."),
    ],
)
def test_fields_that_have_no_effect_are_named(
    problem: Path, fields: dict[str, Any], named: str
) -> None:
    problem.write_text(json.dumps(PROBLEM | fields))
    with pytest.warns(UserWarning, match=r"hall\.json: fields without effect: ") as found:
        assert load_league(problem).revealed == 3
    assert [str(each.message).split("effect: ")[1] for each in found] == [named]


DELAYS = {
    "seed": 5, "minDelay": 2, "maxDelay": 8, "eventModel": "poisson", "pDelay": 0.003,
    "durationModel": "gaussian", "gaussMeanRatio": 0.5, "gaussStdRatio": 0.22,
}  # fmt: skip


def test_a_problem_of_2023_has_a_strategy_that_gives_tasks(problem: Path) -> None:
    (problem.parent / "hall.tasks").write_text("2\n2\n5\n")
    given = {"taskAssignmentStrategy": "roundrobin", "numTasksReveal": 2}
    problem.write_text(json.dumps(PROBLEM | given))
    found = load_league(problem)
    assert (found.strategy, found.year, found.revealed) == ("roundrobin", 2023, 4)
    (problem.parent / "hall.tasks").write_text("2\n2\n4,5\n")
    with pytest.raises(LayoutError, match=r"hall\.tasks: task 1 has 2 locations; with task"):
        load_league(problem)


def test_a_problem_of_2026_has_ticks_and_delays(problem: Path) -> None:
    problem.write_text(json.dumps(PROBLEM | {"agentSize": 0.5, "agentCounter": 3}))
    found = load_league(problem)
    assert (found.year, found.ticks, found.robot_size, found.delays) == (2026, 3, 0.5, None)
    problem.write_text(json.dumps(PROBLEM | {"version": "2026 LoRR", "delayConfig": DELAYS}))
    found = load_league(problem)
    delays = Delays(5, 2, 8, "poisson", 0.003, "gaussian", 0.5, 0.22)
    assert (found.year, found.ticks, found.delays) == (2026, 10, delays)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"teamSize": 4}, "teamSize is 4, but "),
        ({"teamSize": 0}, "teamSize is 0; it must be a whole number, 1 to 1000000"),
        ({"teamSize": True}, "teamSize is True; it must be a whole number"),
        ({"teamSize": 2.0}, "teamSize is 2.0; it must be a whole number"),
        ({"mapFile": 3}, "mapFile is 3; it must be a text"),
        ({"mapFile": "a\0"}, "a file name has no null character"),
        ({"numTasksReveal": float("nan")}, "numTasksReveal is nan; it must be a number, 0 to"),
        ({"numTasksReveal": -1}, "numTasksReveal is -1; it must be a number"),
        ({"taskAssignmentStrategy": "x"}, "'x'; allowed: roundrobin, roundrobin_fixed, greedy"),
        ({"agentCounter": 0}, "agentCounter is 0; it must be a whole number, 1 to 1000"),
        ({"agentSize": 1.1}, "agentSize is 1.1; it must be a number, 0.001 to 1"),
        ({"delayConfig": 3}, "delayConfig is 3; it must be an object"),
        ({"delayConfig": DELAYS | {"maxDelay": 1}}, "delayConfig: maxDelay is 1; it must be a who"),
        ({"delayConfig": {"seed": 1}}, "delayConfig: minDelay is missing; it must be a whole num"),
    ],
)
def test_a_wrong_value_of_a_problem_is_named(
    problem: Path, change: dict[str, Any], message: str
) -> None:
    assert message in refusal(load_league, problem, json.dumps(PROBLEM | change))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"{", "not JSON: "),
        (b"\xff", "invalid start byte"),
        (b"[" * 90_000, "90,000 open brackets are more than MAX_DEPTH = 20"),
        (b"[]", "a JSON list where there must be an object"),
        (b"{}", "teamSize is missing; it must be a whole number"),
    ],
)
def test_what_is_no_problem_is_refused(problem: Path, data: bytes, message: str) -> None:
    assert message in refusal(load_league, problem, data)


def test_a_problem_that_is_too_long_is_refused(problem: Path) -> None:
    problem.write_bytes(b" " * 100_001)
    with pytest.raises(OSError, match="it is longer than 100,000 bytes"):
        load_league(problem)


def test_files_of_a_problem_that_do_not_fit_are_named(problem: Path) -> None:
    problem.write_text(json.dumps(PROBLEM))
    (problem.parent / "hall.tasks").write_text("0\n")
    with pytest.raises(LayoutError, match="has no tasks; it must have one or more"):
        load_league(problem)
    (problem.parent / "hall.tasks").write_text("1\n5\n")
    (problem.parent / "hall.agents").write_text("2\n4\n4\n")
    with pytest.raises(LayoutError, match=r"robots 0 and 1 both start in \(1, 1\)"):
        load_league(problem)
