"""The command ``warehouse mapf`` on several scenarios, and solvers of users."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import Refused, Warehouse
from helpers.player import said_by

from agents.lab.commands.planners.replay import track_of_plan
from agents.lab.commands.planners.study import Attempt, find_scenarios, shares
from agents.mapf.graph import Graph
from warehouse_core import Layout

HALL = "type octile\nheight 2\nwidth 5\nmap\n.....\n.....\n"

TRIVIAL = "from agents.mapf.problem import Plan\n\ndef mine(problem, seconds, ways=0):\n    "
"""Start of the file of a solver, for two robots that go from cells 0 and 1 to cells 2 and 6."""


def scenario(*ends: tuple[int, int, int, int]) -> str:
    lines = (f"0\thall.map\t5\t2\t{a}\t{b}\t{c}\t{d}\t1" for a, b, c, d in ends)
    return "\n".join(("version 1", *lines, ""))


@pytest.fixture
def folder() -> Path:
    """Return a folder with three scenarios of two robots, the last of which has a longer way."""
    path = Path("scenes")
    path.mkdir()
    (path / "hall.map").write_text(HALL)
    for name, last in (
        ("hall-1", (1, 0, 1, 1)),
        ("hall-2", (1, 0, 1, 1)),
        ("hall-10", (1, 0, 3, 1)),
    ):
        (path / f"{name}.scen").write_text(scenario((0, 0, 2, 0), last))
    return path


def test_scenarios_that_are_solved_are_counted_over_the_number_of_robots(
    folder: Path, warehouse: Warehouse
) -> None:
    Path("mine.py").write_text(
        "from agents.errors import PlanError\nfrom agents.mapf.cbs import solve_cbs\n\n"
        "def mine(problem, seconds):\n    if problem.lower_bound == 3:\n"
        "        raise PlanError('no')\n    return solve_cbs(problem, seconds)\n"
    )
    words = (
        "--planner",
        "mine.py:mine",
        "-r",
        "1,2",
        "-j",
        1,
        "-o",
        "plans.csv",
        "-o",
        "share.svg",
    )
    code, out, err = warehouse("mapf", folder, *words)
    assert (code, err) == (0, "")
    with Path("plans.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [Path(line["file"]).stem for line in lines] == ["hall-1", "hall-2", "hall-10"] * 2
    assert [(line["robots"], line["costs"], line["bound"]) for line in lines] == [
        *[("1", "2", "2")] * 3, *[("2", "", "3")] * 2, ("2", "5", "5"),
    ]  # fmt: skip
    assert "3 of 3" in out
    assert "1 of 3" in out
    assert Path("share.svg").read_text().startswith("<?xml")


def test_by_default_numbers_of_robots_double_as_far_as_the_files_go(
    folder: Path, warehouse: Warehouse
) -> None:
    many = [(col, row, 4 - col, row) for row in (0, 1) for col in range(5)] * 3
    Path(folder, "long.scen").write_text(scenario(*many))
    out = warehouse("mapf", folder / "hall-1.scen", folder / "hall-2.scen", "-j", 1).out
    assert "\u2502      2 \u2502" in out
    assert [path.stem for path in find_scenarios([folder])] == [
        "hall-1", "hall-2", "hall-10", "long"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("scenes -r 3", "--robots is 3; allowed: 1..2, the scenarios of "),
        ("scenes --lifelong 3", "--lifelong goes with one problem, and not with several"),
        ("scenes --drive", "--drive goes with one problem, and not with several"),
        ("scenes -o plan.json", "plan.json: cannot save as .json; allowed: .csv, .svg, .png"),
        ("scenes/hall-1.scen hall.json", "hall.json: several files must be .scen, or folders of"),
        (". scenes", "the folder has no .scen"),
        ("-r 3,4", "several numbers of --robots need scenarios; see also: warehouse compare plan"),
        ("scenes/hall-1.scen -o plan.csv", "plan.csv: one plan is saved as .json or as a replay"),
        ("-r 0", "--robots has '0'; it must be whole numbers, at least 1, as in 32,64"),
        ("-r 99999999", "--robots has 99999999; allowed: 1..10000"),
    ],
)
def test_what_does_not_go_with_several_scenarios_is_named(
    words: str, message: str, folder: Path, warehouse: Warehouse
) -> None:
    result = warehouse("mapf", *words.split())
    assert result.code in (1, 2)
    assert message in result.err
    assert result.err.count("\n") == 1


def test_the_picture_has_shares() -> None:
    solved, none = Attempt(3, 4, 4, True, 0.1), Attempt(None, None, 4, False, 0.1)
    found = shares({("a", 5): [solved] * 20, ("a", 9): [solved, none], ("b", 5): [none] * 2})
    assert [found["a"][size].estimate for size in (5, 9)] == [1.0, 0.5]
    assert [found["a"][size].is_known for size in (5, 9)] == [True, False]
    assert found["b"][5].estimate == 0


def test_a_plan_is_saved_as_a_replay_too(folder: Path, warehouse: Warehouse) -> None:
    words = ("--planner", "cbs", "-o", "plan.html", "-o", "plan.json", "-o", "plan.svg")
    assert warehouse("mapf", folder / "hall-10.scen", *words).code == 0
    track = said_by(Path("plan.html").read_text())["tracks"][0]
    assert track["title"] == "cbs, 2 robots"
    assert json.loads(Path("plan.json").read_text())["makespan"] == len(track["time"]) - 1


def test_a_replay_shows_the_headings_of_robots_that_turn() -> None:
    cells, facing = np.array([[0], [0], [1]]), np.array([[0], [1], [1]])
    track = track_of_plan(Graph(Layout([".."])), cells, "T", facing)
    poses = [frame.robots[0] for frame in track.frames]
    assert [pose and pose.heading for pose in poses] == [-np.pi / 2, 0.0, 0.0]


def test_a_replay_shows_each_step_and_the_ways_of_the_last_to_arrive() -> None:
    graph = Graph(Layout(["....", "....", "...."]))
    cells = np.array([[4, 0, 7, 8], [4, 1, 6, 8], [5, 2, 7, 8], [5, 3, 7, 8]])
    track = track_of_plan(graph, cells, "T")
    assert [frame.caption for frame in track.frames] == [
        f"{arrived} of 4 robots in their last cells" for arrived in (1, 1, 3, 4)
    ]
    second = track.frames[2]
    assert [pose.at for pose in second.robots if pose] == [
        (1.5, 1.5), (2.5, 0.5), (3.5, 1.5), (0.5, 2.5),
    ]  # fmt: skip
    assert second.fleet is not None
    assert second.fleet.plans.ways.keys() == {0, 1, 2}
    assert second.fleet.plans.ways[1] == [(0, 2), (0, 3)]
    poses = [frame.robots[2] for frame in track.frames]
    assert [pose and pose.heading for pose in poses] == [None, np.pi, 0.0, 0.0]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("return 7", "planner 'mine.py:mine': it returned 7; needed: a Plan of 2 robots"),
        ("return Plan.of([[0, 1, 2]])", "planner 'mine.py:mine': it returned Plan("),
        (
            "return Plan.of([[0, 1], [1, 6]])",
            "planner 'mine.py:mine': robot 0 is in (0, 1) and not at its goal (0, 2)",
        ),
        (
            "return Plan.of([[1, 2], [0, 6]])",
            "planner 'mine.py:mine': robot 0 is in (0, 1) and not at its start (0, 0)",
        ),
        (
            "return Plan.of([[0, 1, 2], [1, 1, 6]])",
            "planner 'mine.py:mine': step 0: robots 0 and 1 are both to be in (0, 1)",
        ),
        ("return 1 / 0", "planner 'mine.py:mine' failed: ZeroDivisionError: division by zero ("),
    ],
)
def test_a_solver_of_a_user_that_fails_is_named(
    line: str, message: str, folder: Path, refused: Refused
) -> None:
    Path("mine.py").write_text(TRIVIAL + line)
    said = refused("mapf", folder / "hall-1.scen", "--planner", "mine.py:mine")
    assert said.startswith(message)


def test_a_solver_of_a_user_takes_arguments(folder: Path, warehouse: Warehouse) -> None:
    Path("mine.py").write_text(
        f"{TRIVIAL}return Plan.of([[0] * ways + [0, 1, 2], [1] * ways + [1, 6, 6]])"
    )
    for ways, makespan in ((0, 2), (3, 5)):
        words = ("--planner", f"mine.py:mine:ways={ways}", "-o", "plan.json")
        assert warehouse("mapf", folder / "hall-1.scen", *words).code == 0
        assert json.loads(Path("plan.json").read_text())["makespan"] == makespan


def test_a_solver_of_a_user_gets_the_seed(folder: Path, warehouse: Warehouse) -> None:
    ways = TRIVIAL.replace("ways=0", "seed=9")
    Path("mine.py").write_text(f"{ways}return Plan.of([[0] * seed + [0, 1, 2], [1, 6, 6]])")
    words = ("--planner", "mine.py:mine", "--seed", "3", "-o", "plan.json")
    assert warehouse("mapf", folder / "hall-1.scen", *words).code == 0
    assert json.loads(Path("plan.json").read_text())["makespan"] == 5


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mine.py:mine:w=2", "planner 'mine.py:mine' takes no argument 'w'; allowed: ways=VALUE"),
        ("lacam:w=2", "planner 'lacam' takes no argument 'w'; allowed: "),
        ("mine.py:short", "function 'mine.py:short' takes no problem and seconds; needed: these"),
    ],
)
def test_a_solver_without_what_is_needed_is_named(
    name: str, message: str, folder: Path, refused: Refused
) -> None:
    Path("mine.py").write_text(f"{TRIVIAL}pass\n\ndef short(problem): pass\n")
    said = refused("mapf", folder / "hall-1.scen", "--planner", name)
    assert said.startswith(message)
