"""Tabular Q-learning: its update, its choices, and its results."""

import random
from collections.abc import Iterator
from typing import Any

import pytest

from agents.lab.trials.task import Task
from agents.learning import q_learning
from agents.learning.q_learning import ALPHA, GAMMA, QAgent, QTable, best_action, learn, state_of
from warehouse_core import Layout, Observation, WarehouseEnv
from warehouse_core.task.encoding import NOWHERE
from warehouse_core.world.actions import ACTIONS

ROOM = Layout(["######", "#..#.#", "#P..D#", "######"])
NOTHING = [0.0] * len(ACTIONS)


class Corridor:
    """An environment in which each step moves one cell to the right, with given rewards."""

    def __init__(self, *steps: tuple[float, bool, bool]) -> None:
        self.steps = steps
        self.actions: list[int] = []
        self.seeds: list[int] = []

    def reset(self, randomize: bool, seed: int) -> Observation:
        assert randomize
        self.seeds.append(seed)
        self.script = iter(self.steps)
        return self._observe(0)

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.actions.append(action)
        reward, terminated, truncated = next(self.script)
        self.place += 1
        return self._observe(self.place), reward, terminated, truncated, {}

    def _observe(self, place: int) -> Observation:
        self.place = place
        observation = WarehouseEnv().reset()
        observation["robot_pos"] = (0, place)
        return observation


def state_at(place: int) -> q_learning.QState:
    return (0, place), (1, 3), False


def run(env: Corridor, table: QTable, steps: int = 1, seed: int = 1) -> list[tuple[int, bool]]:
    """Learn for a number of steps and return what was yielded."""
    episodes: Iterator[tuple[int, bool]] = learn(table, env, steps, seed)  # type: ignore[arg-type]
    return list(episodes)


@pytest.fixture
def no_exploring(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(q_learning, "EPSILON", 0.0)


# The states.


def test_a_state_has_the_robots_cell_its_goal_and_whether_it_holds_the_item() -> None:
    env = WarehouseEnv(start_pos=(1, 2))
    observation = env.reset()
    pickup, dropoff = observation["pickup_pos"], observation["dropoff_pos"]
    assert state_of(observation) == ((1, 2), pickup, False)
    observation["has_item"] = True
    assert state_of(observation) == ((1, 2), dropoff, True)
    observation["dropoff_pos"] = None
    assert state_of(observation) == ((1, 2), NOWHERE, True)


# The update.


@pytest.mark.parametrize(("terminated", "future"), [(True, 0.0), (False, 8.0)])
def test_a_value_moves_towards_the_reward_and_the_next_value_unless_the_episode_terminated(
    terminated: bool, future: float, no_exploring: None
) -> None:
    table = QTable()
    table[state_at(0)] = [0, 0, 2.0, 0, 0, 0, 0]
    table[state_at(1)] = [0, 8.0, 0, 0, 0, 0, 1.0]
    run(Corridor((0.5, terminated, True)), table)
    towards = 0.5 + GAMMA * future
    assert table[state_at(0)] == pytest.approx([0, 0, 2 + ALPHA * (towards - 2), 0, 0, 0, 0])
    assert table[state_at(1)] == [0, 8.0, 0, 0, 0, 0, 1.0]


def test_a_bump_into_a_wall_counts_for_the_state_it_happened_in(no_exploring: None) -> None:
    # The state before and after is the same, and so is its list of values.
    env = WarehouseEnv(["P.D"], start_pos=(0, 1), max_steps=1)
    table = QTable()
    for _ in learn(table, env, 200, 1):
        pass
    bumps = [values[ACTIONS.index("N")] for values in table.values() if values[0]]
    assert bumps
    assert all(value < 0 for value in bumps)


def test_episodes_are_whole_and_their_ends_are_yielded(no_exploring: None) -> None:
    steps = [(0.0, False, False), (0.0, False, False), (0.0, True, False)]
    assert run(Corridor(*steps), QTable(), steps=4) == [(3, True), (6, True)]
    assert run(Corridor((0.0, False, True)), QTable(), steps=2) == [(1, False), (2, False)]


# The choice of actions.


def test_the_highest_value_is_chosen_at_random_among_equals() -> None:
    stream = random.Random(1)
    assert best_action([0, -1, 3, 2, 0, 0, 0], stream) == 2
    chosen = {best_action([1, 0, 1, 0, 0, 0, 1], stream) for _ in range(50)}
    assert chosen == {0, 2, 6}
    assert {best_action(NOTHING, stream) for _ in range(200)} == set(range(7))


def test_an_epsilon_of_the_actions_is_random() -> None:
    env = Corridor((0.0, False, True))
    table = QTable({state_at(0): [0, 0, 0, 1e9, 0, 0, 0]})
    run(env, table, steps=3000)
    share = sum(action != 3 for action in env.actions) / 3000
    assert share == pytest.approx(q_learning.EPSILON * 6 / 7, abs=0.02)
    assert set(env.actions) == set(range(7))


def test_training_uses_its_own_seeds() -> None:
    env = Corridor((0.0, False, True))
    run(env, QTable(), steps=1000)
    assert len(set(env.seeds)) > 900
    assert max(env.seeds) < q_learning.TRAINING_SEEDS


# The result.


def learned(steps: int, seed: int = 1) -> QTable:
    table = QTable()
    for _ in learn(table, WarehouseEnv(ROOM), steps, seed):
        pass
    return table


def test_the_shortest_paths_are_learned() -> None:
    table = learned(20_000)
    rows = Task(ROOM).evaluate(lambda seed: QAgent(table, seed), range(20)).rows
    assert [row.steps for row in rows] == [row.needed for row in rows]


def test_a_seed_repeats_the_table() -> None:
    assert learned(500) == learned(500)
    assert learned(500) != learned(500, seed=2)


# The agent.


def test_the_reason_is_the_value_of_the_action() -> None:
    env = WarehouseEnv(ROOM, start_pos=(1, 1))
    table = QTable({((1, 1), (2, 1), False): [-1.0, 2.25, 7.04, 0.0, 0.0, 0.0, 0.0]})
    agent = QAgent(table)
    assert agent.act(env.reset()) == "S"
    assert agent.reason == "worth 7.0"
    agent.reset()
    assert agent.reason == ""


def test_an_agent_with_an_empty_table_acts_at_random_and_leaves_it_empty() -> None:
    observation, table = WarehouseEnv().reset(), QTable()
    agent = QAgent(table, seed=1)
    actions = [agent.act(observation) for _ in range(100)]
    assert set(actions) == set(ACTIONS)
    assert not table
    agent.reset()
    assert [agent.act(observation) for _ in range(100)] == actions
    other = QAgent(table, seed=2)
    assert [other.act(observation) for _ in range(100)] != actions
