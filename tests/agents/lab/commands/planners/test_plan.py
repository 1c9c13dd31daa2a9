"""The command ``warehouse plan``, and users' solvers."""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import Warehouse, write_mine
from helpers.mapf_validator import plan_conflict
from helpers.player import said_by

from agents.lab.commands.planners.plan import track_of_plan
from agents.mapf.graph import Graph
from warehouse_core import Layout
from warehouse_core.motion.backends import load_backend

BAY = ("...", "#.#")
"""Two robots at the ends of a corridor swap places with the help of a bay in its middle."""

TRIVIAL = "from agents.mapf.problem import Plan\n\ndef mine(problem, seconds, ways=0):\n    "
"""Start of the file of a solver for the scenario of ``hall``."""

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


@pytest.fixture
def hall() -> str:
    """Return a scenario of two robots that go from cells 0 and 1 to cells 2 and 6."""
    write_map("hall.map", (".....", "....."))
    ends = ((0, 0, 2, 0), (1, 0, 1, 1))
    lines = (f"0\thall.map\t5\t2\t{a}\t{b}\t{c}\t{d}\t1" for a, b, c, d in ends)
    Path("hall.scen").write_text("\n".join(("version 1", *lines, "")))
    return "hall.scen"


def rows_of(out: str) -> dict[str, list[str]]:
    """Return the cells of each row of a table by its name."""
    lines = [line.split("\u2502")[1:-1] for line in out.splitlines() if line[:1] == "\u2502"]
    return {line[0].strip(): [cell.strip() for cell in line[1:]] for line in lines}


def paths_in(file: str) -> tuple[np.ndarray, list[str]]:
    """Return the cells, rows and columns ``[T, R, 2]``, and the headings in a table of paths."""
    with Path(file).open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    robots = 1 + max(int(row["robot"]) for row in rows)
    cells = np.array([[int(row["row"]), int(row["col"])] for row in rows])
    return cells.reshape(-1, robots, 2), [row["heading"] for row in rows]


@pytest.mark.parametrize("planner", ["cbs", "lacam", "windowed"])
def test_plans_for_a_scenario_are_measured_next_to_the_bound(bay, planner, warehouse) -> None:
    code, out, err = warehouse("plan", bay, "--planner", planner, "-o", "a.csv", "-o", "a.html")
    assert (code, err) == (0, "")
    found = rows_of(out)
    assert found["lower bound"][:3] == ["2", "4", "1.000"]
    (cells, headings), makespan = paths_in("a.csv"), int(found[planner][0])
    assert len(cells) == makespan + 1
    assert {*headings} == {""}
    numbers = (cells @ [3, 1]).tolist()
    assert plan_conflict(BAY, [0, 2], [2, 0], numbers) is None
    track = said_by(Path("a.html").read_text())["tracks"][0]
    assert (track["title"], len(track["time"])) == (f"{planner}, 2 robots", makespan + 1)
    if planner == "cbs":
        assert found["cbs"][:3] == ["4", "7", "1.750"]


def test_paths_of_robots_with_headings_have_them(bay: str, warehouse: Warehouse) -> None:
    words = ("--moves", "turn", "--plan-seconds", 1, "--planner", "lacam", "-o", "plan.csv")
    code, out, err = warehouse("plan", bay, *words)
    assert (code, err) == (0, "")
    cells, headings = paths_in("plan.csv")
    facing = np.array(headings).reshape(cells.shape[:2])
    assert facing[0].tolist() == ["E", "E"]
    moves = np.diff(cells, axis=0)
    ahead = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}
    for step, robot in np.argwhere(moves.any(axis=2)).tolist():
        assert tuple(moves[step, robot]) == ahead[facing[step, robot]]
    assert int(rows_of(out)["lacam"][0]) == len(moves) > int(rows_of(out)["lower bound"][0])


@pytest.mark.parametrize("moves", ["compass", "turn"])
def test_auto_is_run_by_default_and_says_what_it_chose(moves, bay, warehouse) -> None:
    code, out, err = warehouse("plan", bay, "--moves", moves, "--plan-seconds", 1)
    assert (code, err) == (0, "")
    assert [*rows_of(out)][-1] == "auto"
    assert out.startswith("--planner auto chose lacam: ")


def test_a_planner_without_a_plan_is_reported_next_to_the_others(bay, warehouse) -> None:
    write_mine("next_cells", "pass", "seen.cells")
    words = ("--planner", "mine.py:Mine", "--plan-seconds", 0.05)
    code, out, err = warehouse("plan", bay, *words, "--planner", "lacam")
    assert code == 0
    assert rows_of(out)["mine.py:Mine"][:3] == ["none"] * 3
    assert err.startswith("warehouse: mine.py:Mine: no plan after 0.05 s and ")
    assert warehouse("plan", bay, *words).code == 1


def test_bodies_that_need_pymunk_are_refused_before_the_plans(refused, monkeypatch) -> None:
    load_backend.cache_clear()
    monkeypatch.setitem(sys.modules, "warehouse_physics", None)
    said = refused("plan", "--robots", 2, "--drive")
    assert said.startswith("backend 'driving' needs warehouse_physics, which is not installed: ")
    assert said.endswith("pip install 'pymunk<8,>=7.1'")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            "--moves turn --planner pibt:guidance=lanes",
            "planner 'pibt:guidance=lanes' does not support headings; it needs",
        ),
        ("bay.scen --robots 3", "--robots is 3; allowed: 1..2, the scenarios of bay.scen"),
        ("bay.scen --layout hall", "scenario 1 is for 2 x 3 cells"),
    ],
)
def test_impossible_plans_are_refused_with_the_reason(bay, options, words, refused) -> None:
    assert words in refused("plan", *options.split())


def test_robots_of_generated_problems_are_in_the_largest_part(warehouse, refused) -> None:
    write_map("two.map", ("..#....", "..#...."))
    code, out, _ = warehouse("plan", "--layout", "two.map", "--robots", 4, "--seed", 1)
    assert code == 0
    assert "none" not in out
    assert "allowed: 1..8 on this layout" in refused("plan", "--layout", "two.map", "--robots", 9)


def test_plans_are_executed_by_bodies_in_both_ways(warehouse: Warehouse) -> None:
    write_map("hall.map", (".....", "....."))
    options = ["--layout", "hall.map", "--robots", 2, "--planner", "pibt"]
    assert "joint steps" not in warehouse("plan", *options).out
    lines = warehouse("plan", *options, "--drive").out.splitlines()
    found = [[cell.strip() for cell in line.split("\u2502")[1:-1]] for line in lines]
    (stepped,), (driven,) = (
        [row for row in found if row[1:2] == [way]] for way in ("joint steps", "driven through")
    )
    assert stepped[0] == driven[0] == "pibt"
    assert 0 < float(driven[2]) < float(stepped[2])
    assert 0 < float(driven[3].replace(",", "")) < float(stepped[3].replace(",", ""))
    assert stepped[4] == driven[4] == "0"


def test_a_replay_shows_each_step_and_the_paths_of_the_last_to_arrive() -> None:
    graph = Graph(Layout(["....", "....", "...."]))
    cells = np.array([[4, 0, 7, 8], [4, 1, 6, 8], [5, 2, 7, 8], [5, 3, 7, 8]])
    track = track_of_plan(graph, cells, "T")
    assert [frame.caption for frame in track.frames] == [
        f"{arrived} of 4 robots in their final cells" for arrived in (1, 1, 3, 4)
    ]
    second = track.frames[2]
    assert [pose.at for pose in second.robots if pose] == [
        (1.5, 1.5), (2.5, 0.5), (3.5, 1.5), (0.5, 2.5),
    ]  # fmt: skip
    assert second.fleet is not None
    assert second.fleet.plans.paths.keys() == {0, 1, 2}
    assert second.fleet.plans.paths[1] == [(0, 2), (0, 3)]
    poses = [frame.robots[2] for frame in track.frames]
    assert [pose and pose.heading for pose in poses] == [None, np.pi, 0.0, 0.0]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("return 7", "planner 'mine.py:mine': it returned 7; needed: a Plan of 2 robots"),
        (
            "return Plan.of([[0, 1], [1, 6]])",
            "planner 'mine.py:mine': robot 0 is in (0, 1), not at its goal (0, 2)",
        ),
        (
            "return Plan.of([[0, 1, 2], [1, 1, 6]])",
            "planner 'mine.py:mine': step 0: robots 0 and 1 are both to be in (0, 1)",
        ),
        ("return 1 / 0", "planner 'mine.py:mine' failed: ZeroDivisionError: division by zero ("),
    ],
)
def test_a_solver_of_a_user_that_fails_is_named(line, message, hall, refused) -> None:
    Path("mine.py").write_text(TRIVIAL + line)
    said = refused("plan", hall, "--planner", "mine.py:mine")
    assert said.startswith(message)


def test_a_solver_of_a_user_takes_arguments(hall: str, warehouse: Warehouse) -> None:
    Path("mine.py").write_text(
        f"{TRIVIAL}return Plan.of([[0] * ways + [0, 1, 2], [1] * ways + [1, 6, 6]])"
    )
    for ways, makespan in ((0, 2), (3, 5)):
        words = ("--planner", f"mine.py:mine:ways={ways}", "-o", "plan.csv")
        assert warehouse("plan", hall, *words).code == 0
        assert len(paths_in("plan.csv")[0]) - 1 == makespan


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mine.py:mine:w=2", "planner 'mine.py:mine' takes no argument 'w'; allowed: ways=VALUE"),
        ("lacam:w=2", "planner 'lacam' takes no argument 'w'; allowed: "),
        ("mine.py:short", "function 'mine.py:short' cannot be called with two arguments; needed"),
    ],
)
def test_a_solver_that_lacks_something_is_named(name, message, hall, refused) -> None:
    Path("mine.py").write_text(f"{TRIVIAL}pass\n\ndef short(problem): pass\n")
    said = refused("plan", hall, "--planner", name)
    assert said.startswith(message)
