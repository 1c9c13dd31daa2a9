"""The command ``warehouse mapf``."""

import json
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import Refused, Warehouse, write_mine
from helpers.mapf_validator import plan_conflict, step_conflict
from helpers.player import said_by

from agents.lab.commands.planners.floors import find_floor
from agents.mapf.graph import Graph
from warehouse_core.motion.backends import load_backend

BAY = ("...", "#.#")
"""Two robots at the ends of the corridor change places by the bay in its middle."""

SCENARIO = """version 1
0\tbay.map\t3\t2\t0\t0\t2\t0\t2
0\tbay.map\t3\t2\t2\t0\t0\t0\t2
"""


def write_map(name: str, rows: tuple[str, ...]) -> None:
    text = "\n".join(rows).replace("#", "@")
    Path(name).write_text(f"type octile\nheight {len(rows)}\nwidth {len(rows[0])}\nmap\n{text}\n")


@pytest.fixture
def bay() -> str:
    write_map("bay.map", BAY)
    Path("bay.scen").write_text(SCENARIO)
    return "bay.scen"


def rows_of(out: str) -> dict[str, list[str]]:
    """Return the cells of each row of a table by its name."""
    lines = [line.split("\u2502")[1:-1] for line in out.splitlines() if line[:1] == "\u2502"]
    return {line[0].strip(): [cell.strip() for cell in line[1:]] for line in lines}


def cells_in(result: dict, width: int) -> list[list[int]]:
    """Return where the robots are before each step and after the last."""
    steps = {"U": width, "D": -width, "L": -1, "R": 1, "W": 0}
    cells = [[row * width + col for row, col, _ in result["start"]]]
    for moves in zip(*(path.split(",") for path in result["actualPaths"]), strict=True):
        cells.append([cell + steps[move] for cell, move in zip(cells[-1], moves, strict=True)])
    return cells


@pytest.mark.parametrize("planner", ["cbs", "lacam", "windowed"])
def test_plans_for_a_scenario_are_measured_beside_the_bound(
    bay: str, planner: str, warehouse: Warehouse
) -> None:
    code, out, err = warehouse("mapf", bay, "--planner", planner, "-o", "plan.json")
    assert (code, err) == (0, "")
    found = rows_of(out)
    assert found["lower bound"][:3] == ["2", "4", "1.000"]
    result = json.loads(Path("plan.json").read_text())
    assert found[planner][:2] == [str(result["makespan"]), str(result["sumOfCost"])]
    assert plan_conflict(BAY, [0, 2], [2, 0], cells_in(result, 3)) is None
    if planner == "cbs":
        assert found["cbs"][:3] == ["4", "7", "1.750"]
        assert result["events"] in ([[3, 0, 0, 1], [4, 1, 1, 1]], [[3, 1, 1, 1], [4, 0, 0, 1]])
        assert result["tasks"] == [[0, 0, [0, 2]], [1, 0, [0, 0]]]


@pytest.mark.parametrize("planner", ["lacam", "lacam-star", "anytime", "windowed"])
def test_plans_of_robots_with_headings_are_written_as_forward_moves_and_turns(
    planner: str, warehouse: Warehouse
) -> None:
    write_map("hall.map", ("....", "....", "...."))
    words = ("--layout", "hall.map", "--robots", 4, "--moves", "turn", "--plan-seconds", 1)
    saved = ("-o", "plan.json", "-o", "plan.html")
    code, out, err = warehouse("mapf", *words, "--planner", planner, *saved)
    assert (code, err) == (0, "")
    result, found = json.loads(Path("plan.json").read_text()), rows_of(out)
    assert result["actionModel"] == "MAPF_T"
    assert [letter for *_, letter in result["start"]] == ["E"] * 4
    graph = Graph(find_floor("hall.map").layout)
    cells, headings = np.array([4 * row + col for row, col, _ in result["start"]]), np.ones(4, int)
    for letters in zip(*(path.split(",") for path in result["actualPaths"]), strict=True):
        moves, quarters = np.array(letters) == "F", ["RWC".find(each) for each in letters]
        ahead = graph.neighbours[cells, headings]
        assert (ahead[moves] >= 0).all()
        cells = np.where(moves, ahead, cells)
        headings = (headings + np.where(moves, 0, 1 - np.array(quarters))) % 4
    goals = [places for _, _, places in result["tasks"]]
    assert [[*divmod(cell, 4)] for cell in cells.tolist()] == goals
    assert int(found[planner][0]) >= int(found["lower bound"][0])
    track = said_by(Path("plan.html").read_text())["tracks"][0]
    assert len(track["time"]) == result["makespan"] + 1


def test_planners_that_know_headings_are_run_by_default(bay: str, warehouse: Warehouse) -> None:
    code, out, err = warehouse("mapf", bay, "--moves", "turn", "--plan-seconds", 1)
    assert (code, err) == (0, "")
    assert [*rows_of(out)][-3:] == ["lacam", "lacam-star", "anytime"]
    out = warehouse("mapf", bay, bay, "--moves", "turn", "--plan-seconds", 1, "--jobs", 1).out
    assert rows_of(out)["2"] == ["2 of 2"]


def test_some_robots_of_a_scenario_can_be_had(bay: str, warehouse: Warehouse) -> None:
    out = warehouse("mapf", bay, "--robots", 1).out
    assert {row[0] for row in rows_of(out).values()} == {"2"}


def test_a_lifelong_run_on_a_generated_problem_is_written_as_it_was(warehouse: Warehouse) -> None:
    words = ("--layout", "depot", "--robots", 12, "--lifelong", 60, "--seed", 3, "-o", "run.json")
    code, out, err = warehouse("mapf", *words, "--planner", "pibt-lanes:wrong_way=3")
    assert (code, err) == (0, "")
    result, found = json.loads(Path("run.json").read_text()), rows_of(out)
    layout = find_floor("depot").layout
    cells = cells_in(result, layout.width)
    for before, after in pairwise(cells):
        assert step_conflict(layout.rows, before, after) is None
    goals = {number: row * layout.width + col for number, _, (row, col) in result["tasks"]}
    for step, robot, task, place in result["events"]:
        assert (cells[step][robot], place) == (goals[task], 1)
    finished = int(found["pibt-lanes:wrong_way=3"][0])
    assert finished == result["numTaskFinished"] == len(result["events"]) > 0
    assert finished < int(found["nobody in the way"][0])


def test_a_planner_without_a_plan_is_told_beside_those_with_one(
    bay: str, warehouse: Warehouse
) -> None:
    write_mine("next_cells", "pass", "seen.cells")
    words = ("--planner", "mine.py:Mine", "--plan-seconds", 0.05)
    code, out, err = warehouse("mapf", bay, *words, "--planner", "lacam")
    assert code == 0
    assert rows_of(out)["mine.py:Mine"][:3] == ["none"] * 3
    assert err.startswith("warehouse: mine.py:Mine: no plan after 0.05 s and ")
    assert warehouse("mapf", bay, *words).code == 1


def test_a_step_that_takes_too_long_is_lost(warehouse: Warehouse) -> None:
    write_mine("next_cells", "while True: pass", "seen.cells", step=2)
    words = ("--planner", "mine.py:Mine", "--robots", 2, "--lifelong", 3, "--plan-seconds", 0.05)
    code, out, err = warehouse("mapf", "--layout", "hall", *words, "-o", "run.json")
    assert (code, rows_of(out)["mine.py:Mine"][0]) == (0, "0")
    assert "mine.py:Mine: 1 step took more than 0.05 s, first step 1; all robots waited" in err
    result = json.loads(Path("run.json").read_text())
    assert (result["numEntryTimeouts"], result["errors"][0][3]) == (1, 1)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("return seen.cells[::-1].copy()", "robot 0 is to go"),
        ("raise KeyError('me')", "KeyError: 'me' (mine.py, line 9)"),
        ("return None", "the planner returned None; needed"),
    ],
)
def test_a_planner_of_a_user_that_fails_is_named(line: str, words: str, refused: Refused) -> None:
    write_mine("next_cells", line, "seen.cells", step=2)
    options = ("--planner", "mine.py:Mine", "--robots", 2, "--lifelong", 3)
    said = refused("mapf", "--layout", "hall", *options)
    assert said.startswith(f"planner 'mine.py:Mine', step 1: {words}")


def test_bodies_that_need_pymunk_are_refused_before_the_plans(
    refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    load_backend.cache_clear()
    monkeypatch.setitem(sys.modules, "warehouse_physics", None)
    said = refused("mapf", "--robots", 2, "--drive")
    assert said.startswith("backend 'driving' needs warehouse_physics, which is not installed: ")
    assert said.endswith("pip install 'pymunk<8,>=7.1'")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--planner lacam --lifelong 3", "planner 'lacam' plans all ways at once, for one goal a"),
        (
            "--moves turn --planner pibt-lanes",
            "planner 'pibt-lanes' does not know headings; it needs",
        ),
        ("bay.scen --robots 3", "--robots is 3; allowed: 1..2, the scenarios of bay.scen"),
        ("bay.scen --layout hall", "scenario 1 is for 2 x 3 cells"),
    ],
)
def test_what_cannot_be_found_or_done_is_named(
    bay: str, options: str, words: str, refused: Refused
) -> None:
    assert words in refused("mapf", *options.split())


def test_moves_that_there_are_not_are_refused(refused: Refused) -> None:
    assert refused("mapf", "--moves", "east", code=2).endswith("'east'; allowed: compass, turn")
    said = refused("mapf", "--moves", "turn", "--lifelong", 9, code=2)
    assert said == "--moves turn does not go with --lifelong"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0\t2\n0", "1\t2\n0", "scenario 1: goal"),
        ("2\t0\t0\t0\t2\n", "0\t0\t1\t0\t2\n", "robots 0 and 1 have the same start (0, 0)"),
        ("2\t0\t0\t0\t2\n", "2\t0\t2\t0\t2\n", "robots 0 and 1 have the same goal (0, 2)"),
    ],
)
def test_a_scenario_without_a_solution_is_told_at_once(
    bay: str, old: str, new: str, words: str, refused: Refused
) -> None:
    Path(bay).write_text(SCENARIO.replace(old, new, 1))
    assert words in refused("mapf", bay)


def test_a_goal_on_another_part_of_the_floor_is_told_at_once(bay: str, refused: Refused) -> None:
    write_map("bay.map", (".#.", "#.#"))
    assert "robot 0: no way leads from (0, 0) to (0, 2)" in refused("mapf", bay)


def test_robots_of_generated_problems_are_in_the_largest_part(
    warehouse: Warehouse, refused: Refused
) -> None:
    write_map("two.map", ("..#....", "..#...."))
    code, out, _ = warehouse("mapf", "--layout", "two.map", "--robots", 4, "--seed", 1)
    assert code == 0
    assert "none" not in out
    assert "allowed: 1..8 on this layout" in refused("mapf", "--layout", "two.map", "--robots", 9)


def test_plans_are_executed_by_bodies_in_both_ways(warehouse: Warehouse) -> None:
    write_map("hall.map", (".....", "....."))
    options = ["--layout", "hall.map", "--robots", 2, "--planner", "pibt"]
    plain = warehouse("mapf", *options).out
    assert "joint steps" not in plain
    for more in ([], ["--lifelong", 6]):
        lines = warehouse("mapf", *options, *more, "--drive").out.splitlines()
        found = [[cell.strip() for cell in line.split("\u2502")[1:-1]] for line in lines]
        (stepped,), (driven,) = (
            [row for row in found if row[1:2] == [way]] for way in ("joint steps", "driven through")
        )
        assert stepped[0] == driven[0] == "pibt"
        assert 0 < float(driven[2]) < float(stepped[2])
        assert 0 < float(driven[3].replace(",", "")) < float(stepped[3].replace(",", ""))
        assert stepped[4] == driven[4] == "0"
