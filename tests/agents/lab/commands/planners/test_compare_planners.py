"""The command ``warehouse compare planners``."""

import csv
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import Refused, Warehouse, write_mine
from PIL import Image

from agents.lab.commands.planners.compare_planners import BOUND, run_trial

SMALL = (
    "compare", "planners", "--layout", "hall", "--robots", "4, 2,4", "--lifelong", 30, "--jobs", 1,
)  # fmt: skip


run_in_hall = partial(run_trial, layout="hall", steps=30, seconds=10.0)


def test_planners_are_compared_by_size_next_to_the_bound(warehouse: Warehouse) -> None:
    saved = ("--save", "curve.png", "--save", "runs.csv")
    code, out, err = warehouse(*SMALL, "-n", 20, *saved)
    assert (code, err) == (0, "")
    assert "30 steps, 20 seeds from 0" in " ".join(out.split())
    assert out.index("2 \u2502") < out.index("4 \u2502")
    expected = np.mean([run_in_hall(("pibt", 4), seed).throughput for seed in range(20)])
    assert f" {expected:.2f} " in out
    with Path("runs.csv").open(newline="") as file:
        lines = [line for line in csv.DictReader(file) if line["planner"] == "pibt"]
    assert [(line["robots"], line["seed"]) for line in lines] == [
        (str(robots), str(seed)) for robots in (2, 4) for seed in range(20)
    ]
    assert np.mean([float(line["throughput"]) for line in lines[20:]]) == expected
    assert out.count(" to ") == 4
    assert "Fewer" not in out
    assert "Intervals need at least 20 episodes." in warehouse(*SMALL).out
    assert "saved curve.png" in out
    with Image.open("curve.png") as image:
        assert image.format == "PNG"


def test_the_bound_is_more_than_any_planner_reaches_and_exact_for_one_robot() -> None:
    alone = [run_in_hall((name, 1), 0).throughput for name in ("pibt", BOUND)]
    assert alone[0] == alone[1] > 0
    crowded = [run_in_hall((name, 40), 0).throughput for name in ("pibt", BOUND)]
    assert crowded[0] < crowded[1]


def test_steps_that_took_too_long_are_reported(warehouse: Warehouse) -> None:
    write_mine("next_cells", "while True: pass", "seen.cells", step=1)
    words = ("--planner", "mine.py:Mine", "--lifelong", 2, "--plan-seconds", 0.02, "-n", 2)
    code, _, err = warehouse(*SMALL, *words)
    assert code == 0
    assert err.splitlines() == [
        f"warehouse: warning: mine.py:Mine, {robots} robots: 4 steps took more than 0.02 s; "
        "all robots waited"
        for robots in (2, 4)
    ]


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
    said = refused(*SMALL, "--planner", "mine.py:Mine", "-r", 2, "-n", 1)
    assert said.startswith(f"planner 'mine.py:Mine', step 1: {words}")


def scenario(*ends: tuple[int, int, int, int]) -> str:
    lines = (f"0\thall.map\t5\t2\t{a}\t{b}\t{c}\t{d}\t1" for a, b, c, d in ends)
    return "\n".join(("version 1", *lines, ""))


@pytest.fixture
def folder() -> Path:
    """Return a folder with three scenarios of two robots; the last one has a longer path."""
    path = Path("scenes")
    path.mkdir()
    (path / "hall.map").write_text("type octile\nheight 2\nwidth 5\nmap\n.....\n.....\n")
    for number, last in enumerate(((1, 0, 1, 1), (1, 0, 1, 1), (1, 0, 3, 1))):
        (path / f"hall-{number}.scen").write_text(scenario((0, 0, 2, 0), last))
    return path


def test_scenarios_that_are_solved_are_counted_over_the_number_of_robots(folder, warehouse) -> None:
    Path("mine.py").write_text(
        "from agents.errors import PlanError\nfrom agents.mapf.cbs import solve_cbs\n\n"
        "def mine(problem, seconds):\n    if problem.lower_bound == 3:\n"
        "        raise PlanError('no')\n    return solve_cbs(problem, seconds)\n"
    )
    saved = ("-o", "plans.csv", "-o", "share.svg")
    words = ("--planner", "mine.py:mine", "-r", "1,2", "-j", 1, *saved)
    code, out, err = warehouse("compare", "planners", folder, *words)
    assert (code, err) == (0, "")
    with Path("plans.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [Path(line["file"]).stem for line in lines] == ["hall-0", "hall-1", "hall-2"] * 2
    assert [(line["robots"], line["costs"], line["bound"]) for line in lines] == [
        *[("1", "2", "2")] * 3, *[("2", "", "3")] * 2, ("2", "5", "5"),
    ]  # fmt: skip
    assert "3 of 3" in out
    assert "1 of 3" in out
    assert Path("share.svg").read_text().startswith("<?xml")


def test_by_default_numbers_of_robots_double_as_far_as_the_files_go(folder, warehouse) -> None:
    many = [(col, row, 4 - col, row) for row in (0, 1) for col in range(5)] * 3
    Path(folder, "long.scen").write_text(scenario(*many))
    out = warehouse("compare", "planners", folder / "hall-1.scen", folder, "-j", 1).out
    assert "\u2502      2 \u2502" in out
    assert "5 of 5" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("scenes -r 3", "--robots is 3; allowed: 1..2, the scenarios of "),
        ("scenes/hall-1.scen hall.json", "hall.json: unknown format of a problem; allowed: .scen"),
        (". scenes", "the folder has no .scen"),
        ("-r 0", "--robots has '0'; it must be whole numbers, at least 1, as in 32,64"),
        ("--planner lacam", "planner 'lacam' plans whole paths to one goal per robot"),
    ],
)
def test_impossible_comparisons_are_refused_with_the_reason(
    words: str, message: str, folder: Path, warehouse: Warehouse
) -> None:
    result = warehouse("compare", "planners", *words.split())
    assert result.code in (1, 2)
    assert message in result.err
    assert result.err.count("\n") == 1
