"""The command ``warehouse league``."""

import json
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.league import write_hall

from agents.lab.commands.planners.league import usual_name
from warehouse_core.world.robot_runners import load_league

SLOW = ("--step-seconds", 1000)
"""No plan is late, however slow the machine is."""

PLAY = ("league", *SLOW, "--planner", "epibt")


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return a problem: two robots fetch from the one end and bring to the other."""
    monkeypatch.chdir(tmp_path)
    return write_hall()


def rows_of(out: str) -> list[list[str]]:
    """Return the cells of the rows of a table."""
    lines = [line.split("\u2502")[1:-1] for line in out.splitlines() if line[:1] == "\u2502"]
    return [[cell.strip() for cell in line] for line in lines]


def test_a_game_is_played_and_its_result_shown_beside_another(
    hall: str, warehouse: Warehouse, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    code, out, err = warehouse(*PLAY, hall, "--max-steps", 12, "-o", "ours.json")
    assert (code, err) == (0, "")
    assert rows_of(out)[0][:8] == ["hall", "epibt", "2", "12", "2", "", "0", "0"]
    code, out, err = warehouse(*PLAY, hall, "--beside", "ours.json", "-o", "play.html")
    assert (code, err) == (0, "")
    assert [row[:8] for row in rows_of(out)] == [
        ["hall", by, "2", "12", "2", "100.0%", "0", "0"] for by in ("epibt", "theirs")
    ]
    assert "replay" in Path("play.html").read_text()
    assert "saved play.html" in out


def test_what_is_wrong_or_not_known_of_a_result_is_told(hall: str, warehouse: Warehouse) -> None:
    warehouse(*PLAY, hall, "--max-steps", 12, "-o", "theirs.json")
    result = json.loads(Path("theirs.json").read_text())
    for key in ("actualSchedule", "plannerTimes"):
        del result[key]
    Path("theirs.json").write_text(json.dumps(result))
    err = warehouse(*PLAY, hall, "--beside", "theirs.json").err
    assert err == (
        "warehouse: theirs.json: it does not say who had which task; its moves keep the rules\n"
    )
    Path("theirs.json").write_text(json.dumps(result | {"actualPaths": ["C,F", "W,W"]}))
    err = warehouse(*PLAY, hall, "--beside", "theirs.json").err
    assert err == "warehouse: theirs.json: step 2: robot 0 leaves the open cells\n"


def test_the_problem_of_2023_says_who_does_what(
    hall: str, warehouse: Warehouse, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    write_hall("4\n4\n9\n0\n5\n", taskAssignmentStrategy="roundrobin", shape="disc")
    _, out, err = warehouse("league", hall, *SLOW, "--max-steps", 10, "--planner", "epibt:tries=2")
    assert rows_of(out)[0][:5] == ["hall", "epibt:tries=2", "2", "10", "4"]
    assert err == "warehouse: warning: hall.json: fields without effect: 'shape'\n"


def test_the_usual_planner_leads_some_of_a_crowd_at_a_time(hall: str) -> None:
    few = load_league(hall)
    assert usual_name(few, 2.0) == "windowed:groups=200,seconds=1.6,led=2,patience=8"
    some = few._replace(starts=[*few.starts * 2, few.starts[0]])
    assert usual_name(some, 1.0).startswith("windowed:")
    given = usual_name(some._replace(strategy="roundrobin"), 1.0)
    dense = "chains=6,groups=500,seconds=0.8,led=3,patience=8"
    assert given == f"windowed-directed:wrong_way=3,{dense}"
    crowd = few._replace(starts=few.starts * 4)
    denser = "chains=6,groups=800,seconds=0.8,led=4,patience=8"
    assert usual_name(crowd, 1.0) == f"windowed-directed:wrong_way=4,{denser}"
    nearly = few._replace(starts=[*few.starts * 4, few.starts[0]])
    assert usual_name(nearly, 1.0).startswith(
        "windowed-directed:wrong_way=9,chains=6,circulates=True,"
    )
    full = few._replace(starts=few.starts * 5)
    assert (
        usual_name(full, 0.5)
        == "circulation-directed:wrong_way=9,chains=6,samples=1000,seconds=0.4"
    )
    crowd = few._replace(starts=few.starts * 2000)
    assert usual_name(crowd, 1.0) == "epibt-aisles:wrong_way=2,tries=2"
    ticks = few._replace(year=2026, ticks=5)  # three steps are planned at a time
    assert usual_name(ticks, 3.0) == "windowed:groups=200,seconds=0.8,led=2,patience=8"


def test_a_planner_that_breaks_rules_or_knows_no_headings_is_named(
    hall: str, refused: Refused
) -> None:
    line = refused("league", hall, "--planner", "pibt")
    assert line == "planner 'pibt' plans for robots without headings"
    Path("mine.py").write_text(
        "class Mine:\n"
        "    def reset(self): pass\n"
        "    def next_cells(self, situation): return situation.cells\n"
        "    def next_places(self, situation, headings): return [0, 0]\n"
    )
    line = refused("league", hall, "--planner", "mine.py")
    assert line.startswith("robot 1 heads east at (1, 0) and is to be at (0, 0), heading north")
