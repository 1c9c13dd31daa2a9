"""Properties of the environment that PettingZoo's own tests do not check."""

import importlib
import sys
from typing import Any

import numpy as np
import pytest

from warehouse_core import FleetEnv, Layout, pettingzoo_env
from warehouse_core.errors import BackendError, EndedError
from warehouse_core.fleet import People
from warehouse_core.orders import Order
from warehouse_core.pettingzoo_env.spaces import MAX_STATE_ORDERS

YARD = Layout(["......", ".P..D.", "..##.C"])


def arrays_in(value: Any) -> list[np.ndarray]:
    if isinstance(value, dict):
        return [array for each in value.values() for array in arrays_in(each)]
    if isinstance(value, tuple):
        return [array for each in value for array in arrays_in(each)]
    return [value] if isinstance(value, np.ndarray) else []


def waits(env: Any) -> dict[str, int]:
    return dict.fromkeys(env.agents, 4)


def test_both_names_of_the_step_limit_are_allowed() -> None:
    ends = [
        pettingzoo_env.parallel_env(robots=1, **limit).fleet.settings.max_steps
        for limit in ({"max_cycles": 7}, {"max_steps": 7})
    ]
    assert ends == [7, 7]


def test_each_robot_gets_its_row_of_the_fleet() -> None:
    settings = {"orders": 0.4, "battery": 500, "people": 1}
    env = pettingzoo_env.parallel_env(YARD, 3, **settings)
    fleet = FleetEnv(YARD, 3, **settings)
    observations, infos = env.reset(seed=5)
    arrays, info = fleet.reset(5)
    stream = np.random.default_rng(1)
    for _ in range(150):
        for row, agent in enumerate(env.possible_agents):
            expected = {key: values[row] for key, values in arrays.items()}
            expected["action_mask"] = info["action_mask"][row]
            assert observations[agent].keys() == expected.keys()
            assert all(np.array_equal(observations[agent][key], expected[key]) for key in expected)
            assert env.observation_space(agent).contains(observations[agent])
            assert np.array_equal(infos[agent]["action_mask"], info["action_mask"][row])
        actions = stream.integers(7, size=3)
        joint = dict(zip(env.agents, actions.tolist(), strict=True))
        observations, rewards, *_, infos = env.step(dict(reversed(joint.items())))
        arrays, expected_rewards, *_, info = fleet.step(actions)
        assert list(rewards.values()) == expected_rewards.tolist()


def test_a_robot_that_has_ended_leaves_the_agents_and_blocks_others() -> None:
    env = pettingzoo_env.parallel_env(["PD.", "..."], 2, starts=[(0, 0), (1, 1)])
    env.reset(seed=1)
    env.step({"robot_0": 5, "robot_1": 4})
    env.step({"robot_0": 1, "robot_1": 4})
    observations, _, terminated, truncated, _ = env.step({"robot_0": 6, "robot_1": 0})
    assert observations.keys() == {"robot_0", "robot_1"}
    assert terminated == {"robot_0": True, "robot_1": False}
    assert not any(truncated.values())
    assert (env.agents, env.num_agents) == (["robot_1"], 1)
    observations, *_ = env.step({"robot_1": 0})
    assert observations.keys() == {"robot_1"}
    assert env.fleet.cells == [(0, 1), (1, 1)]
    assert env.state()[10] == 0
    assert env.state()[20] == 1
    env.reset()
    assert env.agents == env.possible_agents


def test_without_agents_a_step_is_empty_as_wrappers_of_pettingzoo_expect() -> None:
    env = pettingzoo_env.parallel_env(robots=1, max_cycles=1)
    with pytest.raises(EndedError, match=r"needs a reset\(\)"):
        env.step({})
    env.reset(seed=1)
    with pytest.raises(ValueError, match="no action for robot_0"):
        env.step({})
    env.step(waits(env))
    before = env.state()
    assert env.step({}) == ({}, {}, {}, {}, {})
    assert np.array_equal(env.state(), before)
    with pytest.raises(EndedError, match=r"needs a reset\(\)"):
        env.step({"robot_0": 4})
    env.reset()
    assert env.step(waits(env))[0].keys() == {"robot_0"}


def test_a_state_has_all_robots_and_the_oldest_open_orders() -> None:
    orders = [Order(0, 50 + n, (1, 1), (1, 4)) for n in range(MAX_STATE_ORDERS + 5)]
    starts = [(0, 0), (0, 1)]
    env = pettingzoo_env.parallel_env(YARD, 2, orders=orders, starts=starts, battery=300)
    with pytest.raises(EndedError):
        env.state()
    env.reset(seed=1)
    env.step({"robot_0": 4, "robot_1": 1})
    state = env.state()
    assert env.state_space.contains(state)
    robots, waiting = state[1:21].reshape(2, 10), state[21:].reshape(MAX_STATE_ORDERS, 6)
    assert state[0] == 1
    due = [order.due for order in env.fleet.orders]
    mine = [due[order] for order in env.fleet.order_of if order is not None]
    assert robots.tolist() == [
        [0, 0, 0, 299, 1, 1, 1, 4, mine[0], 1],
        [0, 2, 0, 299, 1, 1, 1, 4, mine[1], 1],
    ]
    rows = [[1, 1, 1, 4, 0, due[order]] for order in env.fleet.open_orders[:MAX_STATE_ORDERS]]
    assert waiting.tolist() == rows
    few = pettingzoo_env.parallel_env(YARD, 2, orders=orders[:3], battery=300)
    few.reset(seed=1)
    assert few.state()[21 + 6 :].tolist() == [-1] * 6 * (MAX_STATE_ORDERS - 1)


def test_headings_are_observed_and_stand_in_the_state() -> None:
    settings: dict[str, Any] = {"starts": [(0, 0), (0, 1)], "moves": "turn"}
    env = pettingzoo_env.parallel_env(YARD, 2, **settings)
    assert env.action_space("robot_0").n == 6
    env.reset(seed=1)
    observations, *_, infos = env.step({"robot_0": 1, "robot_1": 2})
    assert [each["heading"] for each in observations.values()] == [2, 0]
    assert infos["robot_1"]["action_mask"].tolist() == [0, 1, 1, 1, 0, 0]
    state = env.state()
    assert env.state_space.contains(state)
    assert state[1:23].reshape(2, 11)[:, -1].tolist() == [2, 0]
    with pytest.raises(ValueError, match=r"^action 6 is out of range; allowed: 0\.\.5"):
        env.step({"robot_0": 6, "robot_1": 0})
    vectors = pettingzoo_env.parallel_env(YARD, 2, observation="vector", **settings)
    vectors.reset(seed=1)
    seen = vectors.step({"robot_0": 1, "robot_1": 2})[0]
    plain = pettingzoo_env.parallel_env(YARD, 2, observation="vector", starts=settings["starts"])
    plain.reset(seed=1)
    without = plain.step({"robot_0": 4, "robot_1": 4})[0]
    for agent, direction in (("robot_0", [1, 0]), ("robot_1", [-1, 0])):
        assert vectors.observation_space(agent).contains(seen[agent])
        assert seen[agent].tolist() == [
            *without[agent][:-11].tolist(), *direction, *without[agent][-11:].tolist()
        ]  # fmt: skip


def test_pictures_and_text() -> None:
    people = People(1)
    env = pettingzoo_env.parallel_env(YARD, 2, render_mode="ansi", battery=300, people=people)
    env.reset(seed=2)
    text = env.render().splitlines()
    assert [text[row][col] for row, col in env.fleet.cells] == ["R", "R"]
    [(row, col)] = env.fleet.people
    assert text[row][col] == "H"
    env = pettingzoo_env.parallel_env(YARD, 2, 50, "dict", "rgb_array", 8, battery=300)
    env.reset(seed=2)
    assert env.render().shape == (8 * YARD.height, 8 * YARD.width, 3)
    env.close()
    silent = pettingzoo_env.parallel_env()
    with pytest.warns(UserWarning, match="needs a render_mode"):
        assert silent.render() is None


def test_without_pettingzoo_the_error_has_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pettingzoo.utils.conversions", None)
    with pytest.raises(BackendError, match=r"need pettingzoo.*: pip install 'pettingzoo>="):
        importlib.reload(pettingzoo_env)
