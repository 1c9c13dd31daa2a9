"""Training by imitation; run with ``-m learning``; it needs the extra ``rl``."""

from pathlib import Path
from typing import Any

import pytest
from helpers.training import check_resumed, check_seeds, ignore, shorten_exams

from agents.lab.commands.train import make_clone_learner
from agents.lab.trials.random_layouts import VariedLayouts
from agents.lab.trials.task import Task
from agents.learning.clone_agent import CloneAgent
from warehouse_core import Layout

pytestmark = pytest.mark.learning

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
ROUND = 8192
"""Steps after which the network changes."""


def learner(rounds: int = 2, seed: int = 1, teacher: str = "astar", task: Any = None) -> Any:
    return make_clone_learner(teacher, task or Task(ROOM, 30, 30), rounds * ROUND, seed)


def test_the_same_seed_trains_the_same_network() -> None:
    check_seeds(learner)


@pytest.mark.parametrize("teacher", ["astar", "exploring"])
def test_a_training_that_is_resumed_is_the_same_to_the_last_bit(teacher: str) -> None:
    task = Task(VariedLayouts(9, 9, count=30), 100, 100)
    check_resumed(lambda: learner(6, teacher=teacher, task=task), 3 * ROUND)


def test_a_clone_delivers_on_mazes_that_it_has_never_seen() -> None:
    task = Task(VariedLayouts(11, 11, count=200), 300, 300)
    learning = learner(12, task=task)
    before = task.evaluate(learning.agents(), range(40)).delivered.sum()
    learning.learn(ignore)
    after = task.evaluate(learning.agents(), range(40))
    assert isinstance(learning.agents()(0), CloneAgent)
    assert after.delivered.sum() >= 39 > before


def test_a_clone_is_trained_and_run(warehouse, refused, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    shorten_exams(monkeypatch)
    ROOM.save("room.txt")
    words = ("train", "clone", "--from", "exploring", "--layout", "room.txt", "--steps", ROUND)
    result = warehouse(*words, "-o", "a.npz")
    assert (result.code, result.err) == (0, "")
    assert "clone of exploring" in result.out
    assert {path.suffix for path in Path().glob("a.*")} == {
        ".checkpoint", ".csv", ".npz", ".png",
    }  # fmt: skip
    resumed = warehouse(*words, "-o", "a.npz", "--resume")
    assert resumed.out.startswith("resumed after 8,192 of 8,192 steps\n")
    run = ("run", "--agent", "clone:a.npz", "--layout", "room.txt", "--seed", 3, "--no-show")
    assert warehouse(*run).out.startswith("CloneAgent on the grid backend, seed 3")
    assert "add --layout random" in refused("train", "clone", "--size", "9x9", code=2)
    assert "no agent is called 'nobody'" in refused("train", "clone", "--from", "nobody")
    for size in ("4x9", "9x4"):
        assert "must be at least 5 x 5" in refused(
            "train", "clone", "--layout", "random", "--size", size
        )
