"""The command ``warehouse gap`` with a problem of the League."""

import csv
import json
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.league import write_hall

from agents.lab.commands.gap.worlds import DRIVING, PLAN, STOPPING, WORLDS
from agents.lab.commands.planners.league import usual_name
from warehouse_core.world.robot_runners import load_league

PLAY = ("--planner", "epibt", "--step-seconds", 1000, "--jobs", 1)


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return a problem: two robots fetch from the one end and bring to the other."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    return write_hall()


def test_the_plan_of_a_game_is_driven_and_shown_beside_another(
    hall: str, warehouse: Warehouse
) -> None:
    warehouse("league", hall, *PLAY[:4], "--max-steps", 22, "-o", "result.json")
    code, out, err = warehouse("gap", hall, *PLAY, "--beside", "result.json", "-o", "gap.csv")
    assert (code, err) == (0, "")
    lines = Path("gap.csv").read_text(encoding="utf-8").splitlines()
    rows = {(row["by"], row["world"]): row for row in csv.DictReader(lines)}
    assert [*rows] == [(by, world) for by in ("epibt", "theirs") for world in WORLDS]
    for world in WORLDS:
        ours, theirs = ({**rows[by, world], "by": ""} for by in ("epibt", "theirs"))
        assert ours == theirs
    plan, driven, stopped = (
        int(rows["epibt", each]["finished"]) for each in (PLAN, DRIVING, STOPPING)
    )
    assert plan == json.loads(Path("result.json").read_text())["numTaskFinished"]
    assert 0 < stopped <= driven < plan
    joules = float(rows["epibt", DRIVING]["joules"]) / driven
    said = (
        f"Of {plan} tasks bodies that drive through finish {driven} in the same 22 s; a task "
        f"takes robots {2 * 22 / driven:.1f} s and {joules:,.0f} J.\n"
    )
    assert said in out
    assert f"Driving through brings {driven / plan:.0%} of what the plan promises" in out


def test_a_game_without_tasks_has_no_shares(hall: str, warehouse: Warehouse) -> None:
    usual = PLAY[2:]  # without the name of a planner
    out = warehouse("gap", hall, *usual, "--max-steps", 1, "--noise", 0, "--stop", 0).out
    assert usual_name(load_league(Path(hall)), 1000.0) in out
    assert "Of 0 tasks bodies that drive through finish 0 in the same 1 s.\n" in out
    assert "Driving through brings none of what the plan promises, none if robots" in out


def test_what_cannot_be_driven_is_named(hall: str, warehouse: Warehouse, refused: Refused) -> None:
    line = refused("gap", hall, "--planner", "pibt")
    assert line == "planner 'pibt' plans for robots without headings"
    warehouse("league", hall, *PLAY[:4], "--max-steps", 12, "-o", "theirs.json")
    result = json.loads(Path("theirs.json").read_text())
    del result["actualSchedule"]
    Path("theirs.json").write_text(json.dumps(result))
    line = refused("gap", hall, *PLAY, "--beside", "theirs.json")
    assert line == "theirs.json: it does not say who had which task"
    write_hall(agentCounter=3)
    line = refused("gap", hall)
    assert line == "hall.json: a problem of 2026; allowed: 2023 and 2024, whose actions take a step"
