"""Training by PPO. Run with ``-m learning``; it needs the extra ``rl``."""

import pickle
import re
import signal
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import Warehouse, in_the_background
from helpers.training import (
    PROGRAM,
    check_resumed,
    check_seeds,
    equal,
    ignore,
    shorten_exams,
    weights,
)

from agents.lab.commands import train
from agents.lab.commands.train import make_learner
from agents.lab.trials.random_layouts import RandomLayouts
from agents.lab.trials.task import FleetTask, Task
from agents.learning.policy_network import PolicyNetwork, Tiles, input_size, network_input
from agents.learning.ppo_agent import PPOAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout
from warehouse_core.batch import BatchEnv
from warehouse_core.task.encoding import FLEET_TILES, MARKED_TILES

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


def test_a_model_that_cannot_be_written_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learning = learner()

    def full(path: Path) -> None:
        path.write_bytes(b"half a model")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(learning.model, "save", full)
    with pytest.raises(OSError, match="No space"):
        learning.save_model(tmp_path / "m.zip")
    assert not list(tmp_path.iterdir())


def test_a_model_can_be_trained_further(tmp_path: Path) -> None:
    from sb3_contrib import MaskablePPO

    from agents.learning.ppo_training import BatchVecEnv

    learner().save_model(tmp_path / "m.zip")
    env = BatchVecEnv(BatchEnv(128, ROOM, autoreset_mode="SameStep"))
    model = MaskablePPO.load(tmp_path / "m.zip", env=env)
    model.learn(ROUND)
    assert model.num_timesteps == ROUND


def test_the_last_rounds_change_the_network_less_than_the_first() -> None:
    networks: list[PolicyNetwork] = []
    learner(rounds=6).learn(lambda _, __, make: networks.append(make(0)._network))
    changes = [
        sum(float(np.abs(a - b).sum()) for a, b in zip(weights(one), weights(other), strict=True))
        for one, other in pairwise(networks)
    ]
    assert len(changes) == 6
    assert 0 < changes[-1] < changes[0] / 2


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


def test_watch_is_called_at_every_round_and_at_the_end_of_the_last() -> None:
    calls: list[tuple[int, float, PPOAgent]] = []
    make_agent = make_learner(Task(ROOM, 30, 30), ROUND + 1, 1).learn(
        lambda steps, delivers, make: calls.append((steps, delivers, make(0)))
    )
    assert [steps for steps, _, _ in calls] == [0, ROUND, 2 * ROUND]
    assert np.isnan(calls[0][1])
    assert all(0 < delivers <= 1 for _, delivers, _ in calls[1:])
    networks = [agent._network for *_, agent in calls]
    for one, other in pairwise(networks):
        assert not any(map(np.array_equal, weights(one), weights(other)))
    assert equal(networks[2], make_agent(0)._network)


def test_deliveries_in_a_room_are_learned() -> None:
    make_agent = learner(rounds=25).learn(ignore)
    scores = Task(ROOM, 30, 30).evaluate(make_agent, range(100))
    assert scores.delivered.all()
    assert scores.lengths.mean() < 6


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


@pytest.mark.parametrize(
    ("make_batch", "tiles"),
    [
        (lambda: FleetTask(ROOM, robots=2).make_batch(6), FLEET_TILES),
        (lambda: BatchEnv(6, autoreset_mode="SameStep"), MARKED_TILES),
    ],
)
def test_the_rows_have_the_format_of_stable_baselines(
    make_batch: Callable[[], Any], tiles: Tiles
) -> None:
    from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
    from stable_baselines3.common.vec_env import VecCheckNan

    from agents.learning.ppo_training import BatchVecEnv

    batch = make_batch()
    env = BatchVecEnv(batch)
    env.seed(5)
    first = env.reset()
    width = input_size(2, tiles)
    assert env.observation_space.contains(first[0])
    arrays, _ = make_batch().reset(seed=5)
    assert np.array_equal(first, network_input(arrays, tiles))
    assert not np.array_equal(env.reset(), first)  # seeds are used once
    assert is_masking_supported(env)
    assert np.array_equal(get_action_masks(env), batch.action_masks())
    assert np.array_equal(env.env_method("action_masks", indices=[4])[0], batch.action_masks()[4])
    assert env.get_attr("max_steps", indices=[1, 2]) == [200, 200]
    assert env.env_is_wrapped(VecCheckNan) == [False] * 6
    observations, rewards, ended, infos = env.step(np.full(6, 4))
    assert (observations.shape, rewards.shape, ended.shape) == ((6, width), (6,), (6,))
    assert len(infos) == env.num_envs == 6
    with pytest.raises(AttributeError):
        env.get_attr("colour")
    with pytest.raises(NotImplementedError, match="max_steps cannot be set"):
        env.set_attr("max_steps", 3)
    env.close()


def test_the_command_trains_an_agent_that_run_takes(
    warehouse: Warehouse, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:20])
    ROOM.save("room.txt")
    result = warehouse("train", "ppo", "--layout", "room.txt", "--steps", ROUND, "-o", "m.npz")
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("8,192 steps in ")
    assert "saved m.npz\nsaved m.zip\nsaved m.png\n" in result.out
    words = ("--agent", "ppo:m.npz", "--layout", "room.txt", "--seed", 1, "--no-show")
    assert warehouse("run", *words).out.startswith("PPOAgent on the grid backend, seed 1")


def test_the_command_resumes_a_training(
    warehouse: Warehouse, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
