"""The goals of ``WarehouseGoal-v0``, and rewards for any goals."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from helpers.gymnasium_envs import same

from warehouse_core import Layout, LayoutError
from warehouse_core.gymnasium_env import GOAL_ID, ID
from warehouse_core.task.encoding import CELLS_PER_UNIT

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)
ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])


def make(**settings: Any) -> Any:
    return gymnasium.make(GOAL_ID, **settings)


@pytest.mark.parametrize("settings", [{}, {"layout": "trap", "view_radius": 0}, {"layout": ["PD"]}])
def test_the_checker_of_gymnasium_passes(settings: dict[str, Any]) -> None:
    settings = {"randomize": "layout" not in settings, **settings}
    check_env(make(**settings).unwrapped)


def test_the_goal_is_to_be_at_the_dropoff_with_the_item() -> None:
    env = make(layout=ROOM, randomize=False, start_pos=(2, 3))
    seen = [env.reset(seed=1)[0]]
    actions = (NORTH, DROP, WEST, WEST, PICK, SOUTH, EAST, EAST, NORTH)
    results = [env.step(action) for action in actions]
    seen += [result[0] for result in results]
    achieved = np.array([each["achieved_goal"] for each in seen])
    path = [(2, 3), (1, 3), (1, 3), (1, 2), (1, 1), (1, 1), (2, 1), (2, 2), (2, 3), (1, 3)]
    assert (achieved[:, :2] * CELLS_PER_UNIT).round(5).tolist() == [[*cell] for cell in path]
    assert achieved[:, 2].tolist() == [0.0] * 5 + [1.0] * 5
    assert {tuple(each["desired_goal"].tolist()) for each in seen} == {tuple(achieved[-1].tolist())}
    assert [result[1] for result in results] == [-1.0] * 8 + [0.0]
    assert [result[2] for result in results] == [False] * 8 + [True]
    with pytest.raises(ResetNeeded, match="the episode has ended"):
        env.unwrapped.step(WAIT)
    env.reset()
    env.step(WAIT)


def test_observations_do_not_show_the_dropoff() -> None:
    there = [Layout(["######", "#P..D#", "######"]), Layout(["######", "#P.D.#", "######"])]
    seen = [
        make(layout=layout, randomize=False, start_pos=(1, 3), view_radius=1).reset()[0]
        for layout in there
    ]
    assert same(seen[0]["observation"], seen[1]["observation"])
    assert not same(seen[0]["desired_goal"], seen[1]["desired_goal"])
    whole = gymnasium.make(
        ID, layout=there[0], randomize=False, start_pos=(1, 3), view_radius=1, observation="vector"
    ).reset()[0]
    window, numbers = whole[:27].reshape(9, 3)[:, :2].ravel(), np.delete(whole[27:], [5, 6, 7])
    assert seen[0]["observation"].tolist() == [*window, *numbers]


def test_rewards_of_goals_do_not_depend_on_their_number_and_are_those_of_steps() -> None:
    env = make(battery=30)
    achieved, desired, rewards = [], [], []
    for seed in range(5):
        env.action_space.seed(seed)
        _, info = env.reset(seed=seed)
        ended = False
        while not ended:
            action = env.action_space.sample(info["action_mask"])
            observation, reward, terminated, truncated, info = env.step(action)
            achieved.append(observation["achieved_goal"])
            desired.append(observation["desired_goal"])
            rewards.append(reward)
            ended = terminated or truncated
    compute = env.unwrapped.compute_reward
    assert compute(np.array(achieved), np.array(desired), None).tolist() == rewards
    assert compute(np.array(achieved), np.array(achieved), [{}]).tolist() == [0.0] * len(rewards)
    pairs = np.array([achieved, desired])[:, : len(rewards) // 2 * 2].reshape(2, -1, 2, 3)
    assert compute(*pairs, None).shape == pairs.shape[1:3]
    assert compute(achieved[0], desired[0], {}).dtype == np.float32


def test_a_layout_without_a_station_is_refused() -> None:
    for rows in (["P.."], ["..D"]):
        with pytest.raises(LayoutError, match=r"^the layout has no pickup or no dropoff; goals"):
            make(layout=rows, randomize=False).reset()


@pytest.mark.parametrize(
    ("goals", "problem"),
    [
        (([[0, 0, 1], [1]], [0, 0, 1]), "achieved_goal is .*; it must be numbers"),
        (([0, 0, 1], ["a", "b", "c"]), "desired_goal is <U1; it must be numbers"),
        (
            ([0, 1], [0, 1]),
            r"achieved_goal has the shape \(2,\); its last axis must have 3 numbers",
        ),
        (
            ([0, 0, 1], [[0, 0, 1]]),
            r"desired_goal has the shape \(1, 3\); it must have the shape of",
        ),
    ],
)
def test_goals_that_are_none_are_refused(goals: tuple[Any, Any], problem: str) -> None:
    with pytest.raises((TypeError, ValueError), match=f"^{problem}"):
        make().unwrapped.compute_reward(*goals, None)
