"""Training of fleets by imitation. Run with ``-m learning``; it needs the extra ``rl``."""

import pickle
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.training import check_seeds, equal, ignore

from agents.lab.commands import fleet_clone
from agents.lab.commands.fleet_clone import FleetFloors, make_fleet_learner
from agents.learning.clone_planner import ClonePlanner
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from warehouse_core import random_layout

pytestmark = pytest.mark.learning

FLOOR = random_layout(10, 10, 0.2, seed=1)
STEPS = 10_000
"""Steps of about six episodes of eight robots or fewer, more or less."""


def learner(seed: int = 1, teacher: str = "windowed-lanes:groups=0", steps: int = STEPS) -> Any:
    return make_fleet_learner(teacher, FleetFloors(16, FLOOR, 1, seed), steps, seed)


def test_the_same_seed_trains_the_same_network() -> None:
    check_seeds(learner)


def test_a_training_that_is_resumed_is_the_same_to_the_last_bit() -> None:
    begun, stored = learner(), list[bytes]()

    def store_and_stop(done: int, _: float) -> None:
        if done > STEPS / 2:
            stored.append(pickle.dumps(begun.state()))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        begun.learn(store_and_stop)
    whole, resumed = learner(), learner()
    whole.learn(ignore)
    resumed.restore(pickle.loads(stored[0]))
    resumed.learn(ignore)
    assert equal(whole.network(), resumed.network())


def test_a_clone_leads_a_fleet_where_its_teacher_is_not() -> None:
    learning, other = learner(teacher="pibt", steps=30_000), random_layout(12, 8, 0.2, seed=2)

    def reached() -> int:
        planner = ClonePlanner.on(learning.network(), other)
        return run_lifelong(Graph(other), planner, 10, 200, 1).reached

    before = reached()
    learning.learn(ignore)
    assert not learning.network().lanes
    assert reached() > 100 > 2 * before


def test_a_clone_of_a_fleet_is_trained_and_run(
    warehouse: Warehouse, refused: Refused, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fleet_clone, "FINAL_EPISODES", 2)
    FLOOR.save("floor.txt")
    words = ("train", "clone", "--from", "pibt-lanes", "-r", 4, "--steps", 1000)
    result = warehouse(*words, "--layout", "floor.txt", "-o", "a.npz")
    assert result.code == 0
    for row in ("clone of pibt-lanes", "pibt-lanes", "pibt"):
        assert f"{row} " in result.out
    resumed = warehouse(*words, "--layout", "floor.txt", "-o", "a.npz", "--resume")
    assert resumed.out.startswith("resumed after 1,")
    assert warehouse(*words, "--layout", "random", "--layouts", 2, "-o", "b.npz").code == 0
    run = ("fleet", "--planner", "clone:a.npz", "--seed", 3, "--max-steps", 40, "--no-show")
    assert "8 robots (clone:a.npz)" in warehouse(*run).out
    for option, value in (("--size", "9x9"), ("--battery", 100), ("--max-steps", 100)):
        message = refused(*words, option, value, code=2)
        assert "are for a lone robot; 'pibt-lanes' is a planner of fleets" in message
