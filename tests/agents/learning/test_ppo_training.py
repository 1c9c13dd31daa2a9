"""Training by PPO. Run with ``-m learning``; it needs the extra ``rl``."""

import pickle
import re
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import Warehouse, in_the_background
from helpers.training import PROGRAM, check_resumed, check_seeds, equal, ignore, shorten_exams

from agents.lab.commands import train
from agents.lab.commands.train import make_learner
from agents.lab.trials.random_layouts import RandomLayouts
from agents.lab.trials.task import FleetTask, Task
from agents.learning.policy_network import PolicyNetwork, network_input
from agents.learning.ppo_agent import PPOAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout
from warehouse_core.batch import BatchEnv

pytestmark = pytest.mark.learning

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
ROUND = 8192
"""Steps after which the network changes."""


def learner(rounds: int = 1, seed: int = 1) -> Any:
    return make_learner(Task(ROOM, 30, 30), rounds * ROUND, seed)


def test_the_same_seed_trains_the_same_network() -> None:
    check_seeds(learner)


def test_the_network_chooses_what_the_model_chooses(tmp_path: Path) -> None:
    from sb3_contrib import MaskablePPO

    learning = learner(rounds=2)
    learning.learn(ignore)
    learning.save_model(tmp_path / "m.zip")
    learning.save_network(tmp_path / "m.npz")
    model, network = MaskablePPO.load(tmp_path / "m.zip"), PolicyNetwork.load(tmp_path / "m.npz")
    batch = BatchEnv(500, ROOM)
    arrays, info = batch.reset(seed=9)
    for _ in range(10):
        inputs, allowed = network_input(arrays), info["action_mask"]
        expected, _ = model.predict(inputs, deterministic=True, action_masks=allowed)
        logits = np.where(allowed, network.logits(inputs), -np.inf)
        assert np.array_equal(logits.argmax(axis=1), expected)
        arrays, *_, info = batch.step(expected)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.npz", "m.zip"]


@pytest.mark.parametrize(
    "task",
    [
        Task(ROOM, 30, 30),
        Task(RandomLayouts(6, 8, 0.1, 0.3, count=40), 60, 60),
        FleetTask(ROOM, robots=2, max_steps=60),
    ],
    ids=["a room", "random layouts", "a fleet"],
)
def test_a_training_that_is_resumed_is_the_same_to_the_last_bit(task: Task | FleetTask) -> None:
    rows = make_learner(task, 1, 1)._round
    whole, resumed = check_resumed(lambda: make_learner(task, 6 * ROUND, 1), 3 * rows)
    of_whole, of_resumed = (
        pickle.dumps([each.numpy() for each in learning.model.policy.state_dict().values()])
        for learning in (whole, resumed)
    )
    assert of_whole == of_resumed, "the critic too"


def test_a_policy_delivers_in_layouts_that_it_has_not_seen() -> None:
    from agents.learning.ppo_training import FOR_RANDOM_LAYOUTS

    task = Task(RandomLayouts(6, 8, 0.1, 0.3, count=40), 60, 60)
    task = task._replace(layout=task.layout.without(range(100)))  # type: ignore[union-attr]
    learning = make_learner(task, 15 * ROUND, 1)
    assert learning.model.gamma == FOR_RANDOM_LAYOUTS["gamma"]
    learning.learn(ignore)
    network = learning.network()
    assert network.layers[0][0].shape[0] == 128
    scores = task.evaluate(lambda seed: PPOAgent(network, revisit=4), range(100))
    assert scores.delivered.mean() > 0.95
    assert scores.ratio is not None
    assert scores.ratio.high < 2, "without training it is above 4"


def test_robots_that_share_a_network_deliver_more_than_greedy_ones() -> None:
    task = FleetTask(ROOM, robots=2, max_steps=60)
    trained = make_learner(task, 20 * ROUND, 1).learn(ignore)
    learned, greedy = (task.evaluate(each, range(20)) for each in (trained, GreedyAgent))
    assert learned.per_hour.low > greedy.per_hour.high


def test_the_command_trains_an_agent_that_run_takes(warehouse, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:20])
    ROOM.save("room.txt")
    result = warehouse("train", "ppo", "--layout", "room.txt", "--steps", ROUND, "-o", "m.npz")
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("8,192 steps in ")
    assert "saved m.npz\nsaved m.zip\nsaved m.png\n" in result.out
    words = ("--agent", "ppo:m.npz", "--layout", "room.txt", "--seed", 1, "--no-show")
    assert warehouse("run", *words).out.startswith("PPOAgent on the grid backend, seed 1")


def test_the_command_resumes_a_training(warehouse: Warehouse, tmp_path, monkeypatch) -> None:
    """A training is killed here; test_train.py also interrupts and terminates one."""
    monkeypatch.chdir(tmp_path)
    shorten_exams(monkeypatch)
    ROOM.save("room.txt")
    words = ("train", "ppo", "--layout", "room.txt", "--steps", 8 * ROUND)
    with in_the_background(PROGRAM, *words) as process:
        while not Path("ppo.checkpoint").exists():
            assert process.poll() is None
            time.sleep(0.001)
        time.sleep(0.1)  # between two checkpoints
        process.kill()
        process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL
    resumed = warehouse(*words, "--resume")
    assert re.match(r"resumed after [\d,]+ of 65,536 steps\n", resumed.out)
    warehouse(*words, "-o", "whole.npz")
    assert Path("ppo.csv").read_text() == Path("whole.csv").read_text()
    assert equal(PolicyNetwork.load("ppo.npz"), PolicyNetwork.load("whole.npz"))
