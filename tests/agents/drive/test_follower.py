"""The follower drives the moves of grid agents, without hits and sooner than move by move."""

import numpy as np
import pytest

from agents.drive import Follower
from agents.registry import make_agent
from warehouse_core import Layout, WarehouseEnv, record_episode, replay_episode
from warehouse_core.records import diagnose, drive_summary
from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.drive import DriveEnv


@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_it_delivers_without_hits_and_sooner_than_move_by_move(drive):
    env = DriveEnv(spec=RobotSpec(drive=drive))
    for seed in range(2):
        episode = record_episode(
            env, Follower(env, make_agent("astar", seed, env.layout)), seed=seed
        )
        summary = drive_summary(episode)
        assert episode.outcome == "delivered"
        assert summary.hits == 0
        assert diagnose(episode).sentence == f"delivered in {episode.seconds:.1f} s"
        steps = record_on_grid(env.layout, episode.cells[0], seed)
        by_moves = replay_episode(steps, backend=f"physics:drive={drive}")
        assert episode.seconds < by_moves.seconds


def record_on_grid(layout, start, seed):
    agent = make_agent("astar", seed, layout)
    return record_episode(WarehouseEnv(layout, start), agent, seed=seed, randomize=False)


@pytest.mark.parametrize("trouble", [{"actuation_noise": 0.1}, {"slippery": "all", "grip": 0.05}])
def test_it_copes_with_noise_and_ice(trouble):
    env = DriveEnv(disturbances=Disturbances(**trouble))
    done = [
        record_episode(env, Follower(env, make_agent("astar", seed, env.layout)), seed=seed).outcome
        for seed in range(2)
    ]
    assert done == ["delivered"] * 2


def test_agents_that_bump_and_wander_are_driven_too():
    env = DriveEnv(max_seconds=60.0)
    for name in ("random", "exploring", "greedy"):
        episode = record_episode(env, Follower(env, make_agent(name, 3, env.layout)), seed=3)
        assert len(set(episode.cells)) > 3


class Stubborn:
    """An agent that always does the same."""

    def __init__(self, action):
        self.action = action

    def reset(self):
        """Forget nothing."""

    def act(self, observation):
        """Act."""
        return self.action


@pytest.mark.parametrize("action", ["N", "WAIT", "PICK"])
def test_a_robot_whose_agent_goes_nowhere_stands_still(action):
    layout = Layout(["######", "#....#", "#P..D#", "######"])
    env = DriveEnv(layout, randomize=False, start_pos=(1, 2), max_seconds=5.0)
    episode = record_episode(env, Follower(env, Stubborn(action)), seed=1)
    assert set(episode.cells) == {(1, 2)}


def test_a_robot_that_was_moved_off_its_line_finds_a_new_one():
    env = DriveEnv(spec=RobotSpec())
    follower = Follower(env, make_agent("astar", 1, env.layout))
    observation, _ = env.reset(seed=12)
    follower.reset()
    for _ in range(30):
        observation, *_ = env.step(follower.act(observation))
    env.robot.position = 1.5, 5.5  # somebody carries the robot away
    env.robot.velocity = 0, 0
    for _ in range(1500):
        observation, _, terminated, truncated, _ = env.step(follower.act(observation))
        if terminated or truncated:
            break
    assert terminated
    assert np.isfinite(env.pose).all()
