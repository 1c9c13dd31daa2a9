"""Stable-Baselines3 trains on ``Warehouse-v0``, with masks. Run with ``-m learning``."""

from typing import Any

import gymnasium
import pytest

from warehouse_core import Layout
from warehouse_core.gymnasium_env import GOAL_ID, ID
from warehouse_core.gymnasium_env.spaces import FORMS

pytestmark = pytest.mark.learning

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])


def make(**settings: Any) -> Any:
    return gymnasium.make(f"warehouse_core.gymnasium_env:{ID}", **settings)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("backend", ["grid", "physics"])
@pytest.mark.parametrize("render_mode", ["rgb_array", "ansi"])
def test_the_checker_of_stable_baselines_passes(form: str, backend: str, render_mode: str) -> None:
    from stable_baselines3.common.env_checker import check_env

    # Every warning is an error; see pyproject.toml.
    check_env(make(observation=form, backend=backend, render_mode=render_mode).unwrapped)


@pytest.mark.parametrize("form", ["vector", "dict"])
@pytest.mark.parametrize("control", ["velocity", "wheels", "force"])
def test_the_checker_of_stable_baselines_passes_under_continuous_control(form, control) -> None:
    from stable_baselines3.common.env_checker import check_env

    env = gymnasium.make("WarehouseDrive-v0", observation=form, control=control)
    check_env(env.unwrapped)


@pytest.mark.parametrize(("form", "policy"), [("dict", "MultiInput"), ("vector", "Mlp")])
def test_masked_learning_chooses_only_actions_with_an_effect(form: str, policy: str) -> None:
    from sb3_contrib import MaskablePPO

    env = make(layout=ROOM, observation=form, max_steps=30)
    settings = {"n_steps": 64, "batch_size": 32, "n_epochs": 2, "seed": 0, "device": "cpu"}
    model = MaskablePPO(f"{policy}Policy", env, **settings)
    model.learn(300)
    assert model.num_timesteps >= 300
    observation, info = env.reset(seed=1)
    useless = 0
    for _ in range(60):
        action, _ = model.predict(observation, action_masks=env.unwrapped.action_masks())
        useless += not info["action_mask"][action]
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            observation, info = env.reset()
    assert useless == 0


def test_hindsight_replays_episodes_with_the_goals_that_they_achieved() -> None:
    from stable_baselines3 import DQN, HerReplayBuffer

    env = gymnasium.make(GOAL_ID, layout=ROOM, max_steps=30)
    settings = {"learning_starts": 60, "batch_size": 32, "seed": 0, "device": "cpu"}
    model = DQN("MultiInputPolicy", env, replay_buffer_class=HerReplayBuffer, **settings)
    model.learn(200)
    batch = model.replay_buffer.sample(300)
    goals = (batch.next_observations[name].numpy() for name in ("achieved_goal", "desired_goal"))
    rewards = env.unwrapped.compute_reward(*goals, None)
    assert batch.rewards[:, 0].tolist() == rewards.tolist()
    assert 0.05 < (rewards == 0).mean() < 0.95
