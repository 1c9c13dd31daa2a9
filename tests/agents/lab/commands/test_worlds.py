"""``warehouse race --worlds``: one agent in several worlds."""

import re
from pathlib import Path
from typing import Any

import pytest
import typer
from helpers.command_line import Refused, Warehouse

from agents.lab.commands.worlds import misses, split_worlds, world_sentence
from warehouse_core import Episode, EpisodeRecorder, Layout, WarehouseEnv

WORLDS = "grid,physics,icy"


def rows_of(out: str) -> dict[str, list[str]]:
    """Return the cells of each row of a printed table, by the name of the row."""
    lines = [re.split(" *│ *", line)[1:-1] for line in out.splitlines() if line.startswith("│")]
    return {name: cells for name, *cells in lines}


def test_a_plan_that_delivers_on_the_grid_fails_on_ice_and_an_agent_that_looks_delivers(
    warehouse: Warehouse,
) -> None:
    blind = warehouse("race", "--worlds", WORLDS, "--max-steps", 24, "--save", "race.html")
    assert (blind.code, blind.err) == (0, "")
    outcomes = rows_of(blind.out)["outcome"]
    assert outcomes == ["delivered", "delivered", "out of time"]
    words = " ".join(blind.out.split())
    assert re.search(
        r"icy: in step 2 at \(6, 2\), the robot came to rest 0\.6 m short of \(6, 1\) on the "
        r"slippery floor\. Its plan went on as if it had arrived, hit walls \d times, and ended at "
        r"\(\d, \d\) without the item\.",
        words,
    )
    assert "physics:" not in words
    reverse = warehouse("race", "--worlds", "icy,grid", "--max-steps", 24, "--save", "race.png")
    assert "icy: in step 2 at (6, 2), the robot came to rest" in reverse.out
    looking = warehouse("race", "--worlds", WORLDS, "--agent", "astar", "--save", "race.png")
    assert rows_of(looking.out)["outcome"] == ["delivered"] * 3
    words = " ".join(looking.out.split())
    assert re.search(r"looked where it was, and delivered in 23 steps instead of 18\.", words)


def test_a_body_drives_the_path_of_the_grid_in_one_go(warehouse: Warehouse) -> None:
    words = ("race", "--agent", "astar", "--save", "race.png", "--worlds")
    rows = rows_of(warehouse(*words, "grid,physics,driving").out)
    assert rows["outcome"] == ["delivered"] * 3
    assert rows["steps"] == ["18"] * 3
    _, stopping, driving = rows["seconds"]
    assert float(driving) < 0.75 * float(stopping)
    assert int(rows["stops"][2]) < int(rows["stops"][1]) / 2
    wheels = warehouse(*words, "driving:drive=differential,mass=60")
    assert rows_of(wheels.out)["outcome"] == ["delivered"]


@pytest.mark.parametrize(
    ("worlds", "expected"),
    [
        ("grid", ["grid"]),
        ("grid,physics:mass=90,drive=differential,icy", None),
        ("physics:mass=90,mine.py:Mine:x=1", ["physics:mass=90", "mine.py:Mine:x=1"]),
        ("grid,a=c/mine.py,icy", ["grid", "a=c/mine.py", "icy"]),
        ("mine.py:x=1,a=b/mine.py", ["mine.py:x=1", "a=b/mine.py"]),  # a file that exists
        ("mine.py:x=1,a=c/mine.py", ["mine.py:x=1,a=c/mine.py"]),
    ],
)
def test_settings_follow_the_name_of_a_world(worlds, expected, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a=b").mkdir()
    Path("a=b", "mine.py").touch()
    settings = ["grid", "physics:mass=90,drive=differential", "icy"]
    assert split_worlds(worlds) == (expected or settings)


@pytest.mark.parametrize(
    ("worlds", "message"),
    [
        ("", "--worlds is ''; allowed: names as in grid,physics,icy"),
        ("grid,,icy", "--worlds is 'grid,,icy'; allowed"),
        ("icy,grid,icy", "--worlds names icy twice; allowed"),
    ],
)
def test_worlds_that_cannot_be_told_apart_are_an_error(worlds: str, message: str) -> None:
    with pytest.raises(typer.BadParameter, match=f"^{re.escape(message)}"):
        split_worlds(worlds)


def test_one_agent_runs_in_worlds_that_exist(refused: Refused) -> None:
    words = ("race", "--worlds", WORLDS)
    assert refused(*words, "--agent", "greedy", "--agent", "astar", code=2) == (
        "--agent is given 2 times; --worlds takes one agent"
    )
    assert refused(*words, "--backend", "grid", code=2) == (
        "--backend cannot be combined with 'race --worlds'"
    )
    assert refused("race", "--worlds", "grid,sleigh").startswith("no backend is called 'sleigh'")
    assert "row 0, column 0 is wall" in refused(*words, "--slippery", "0,0")


def sentence_in(warehouse: Warehouse, world: str, *words: object) -> str:
    done = warehouse("race", "--worlds", f"grid,{world}", *words, "--save", "race.png")
    assert done.code == 0
    return " ".join(done.out.split())


def test_a_sentence_names_the_cause(warehouse: Warehouse) -> None:
    weak = sentence_in(warehouse, "physics:motor_strength=0.2", "--max-steps", 24)
    assert "the robot came to rest 0.8 m short of (6, 2) with 20% of its force." in weak
    noisy = sentence_in(warehouse, "physics:noise=0.5,patience=1", "--max-steps", 24)
    assert re.search(r"patience=1: in step 1 at \(6, 3\), the robot .* \(6, 2\)\. Its", noisy)
    failed = sentence_in(warehouse, "icy", "--agent", "greedy", "--max-steps", 24)
    assert "In the end: 9 of 24 steps missed their target cell" in failed


def record(backend: Any, *actions: str) -> Episode:
    env = WarehouseEnv(Layout(["P....D"]), (0, 0), backend=backend)
    env.reset(seed=0)
    recorder = EpisodeRecorder(env)
    for action in actions:
        recorder.step(action)
    return recorder.episode


def test_a_miss_is_a_move_to_a_free_cell_that_ended_elsewhere() -> None:
    assert [*misses(record("grid", "W", "N", "E", "PICK", "E"))] == []
    icy = record("physics:grip=0.01,slippery=0-1+0-2", "N", "E", "E")
    past, short = misses(icy)
    end = icy.motions[1].path[-1, 1]
    assert past == (2, (0, 1), pytest.approx(1.5 - end))
    assert (short.step, short.target) == (3, (0, 3))
    assert past.short < -1 < 0 < short.short
    sentence = world_sentence("ice", icy, record("grid", "N", "E", "E"))
    assert sentence == (
        "ice: in step 2 at (0, 0), the robot slid 1.5 m past (0, 1) on the slippery floor. Its "
        "plan went on as if it had arrived, hit a wall, and ended at (0, 2) without the item."
    )


def test_slippery_cells_limit_the_ice(warehouse: Warehouse) -> None:
    words = ("--slippery", "6,4", "--save", "race.png")
    done = warehouse("race", "--worlds", WORLDS, *words)
    assert rows_of(done.out)["outcome"] == ["delivered"] * 3
    assert "The robot visits the same cells in all worlds." in done.out
    race = warehouse("race", "--agent", "astar", "--backend", "physics:grip=0.05", *words)
    assert "backend physics:grip=0.05,slippery=6-4" in race.out
