"""Tabular Q-learning: its update, its choices, and what it learns."""

import random
from collections.abc import Iterator
from typing import Any

import pytest

from agents.evaluation.samples import FIRST_EXAM_SEED, Task, evaluate
from agents.learning import q_learning
from agents.learning.q_learning import ALPHA, GAMMA, QAgent, QTable, best_action, learn, state_of
from warehouse_core import Layout, Observation, WarehouseEnv
from warehouse_core.task.encoding import NOWHERE
from warehouse_core.world.actions import ACTIONS

ROOM = Layout(["######", "#..#.#", "#P..D#", "######"])
NOTHING = [0.0] * len(ACTIONS)


class Corridor:
    """Stands in for an environment: moves a cell to the right with every step, rewards as told."""

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


def state_at(place: int) -> q_learning.State:
    return (0, place), (1, 3), False


def run(env: Corridor, table: QTable, steps: int = 1, seed: int = 1) -> list[tuple[int, bool]]:
    """Learn for so many steps and return what was yielded."""
    episodes: Iterator[tuple[int, bool]] = learn(table, env, steps, seed)  # type: ignore[arg-type]
    return list(episodes)


@pytest.fixture
def no_exploring(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(q_learning, "EPSILON", 0.0)


# The states.


def test_a_state_is_where_the_robot_is_where_it_has_to_go_and_what_it_holds() -> None:
    env = WarehouseEnv(start_pos=(1, 2))
    observation = env.reset()
    pickup, dropoff = observation["pickup_pos"], observation["dropoff_pos"]
    assert state_of(observation) == ((1, 2), pickup, False)
    observation["has_item"] = True
    assert state_of(observation) == ((1, 2), dropoff, True)
    observation["dropoff_pos"] = None
    assert state_of(observation) == ((1, 2), NOWHERE, True)


# The update.


def test_a_value_moves_towards_the_reward_and_what_the_next_state_is_worth(
    no_exploring: None,
) -> None:
    table = QTable()
    table[state_at(0)] = [0, 0, 2.0, 0, 0, 0, 0]
    table[state_at(1)] = [0, 5.0, 0, 0, 0, 0, 1.0]
    run(Corridor((0.5, False, False), (3.0, True, False)), table)
    towards = 0.5 + GAMMA * 5.0
    assert table[state_at(0)] == pytest.approx([0, 0, 2 + ALPHA * (towards - 2), 0, 0, 0, 0])
    assert table[state_at(1)] == pytest.approx([0, 5 + ALPHA * (3 - 5), 0, 0, 0, 0, 1])


def test_nothing_comes_after_a_delivery_but_much_may_after_a_cut(no_exploring: None) -> None:
    for terminated, future in ((True, 0.0), (False, 8.0)):
        table = QTable()
        table[state_at(0)] = [0, 0, 0, 1.0, 0, 0, 0]
        table[state_at(1)] = [8.0, *NOTHING[1:]]
        run(Corridor((2.0, terminated, True)), table)
        expected = 1 + ALPHA * (2 + GAMMA * future - 1)
        assert table[state_at(0)] == pytest.approx([0, 0, 0, expected, 0, 0, 0])


def test_a_bump_into_a_wall_counts_for_the_state_it_happened_in(no_exploring: None) -> None:
    # The state before and after is the same, and so is its list of values.
    env = WarehouseEnv(["P.D"], start_pos=(0, 1), max_steps=1)
    table = QTable()
    for _ in learn(table, env, 200, 1):
        pass
    bumps = [values[ACTIONS.index("N")] for values in table.values() if values[0]]
    assert bumps
    assert all(value < 0 for value in bumps)


def test_episodes_are_whole_and_their_ends_are_told(no_exploring: None) -> None:
    steps = [(0.0, False, False), (0.0, False, False), (0.0, True, False)]
    assert run(Corridor(*steps), QTable(), steps=4) == [(3, True), (6, True)]
    assert run(Corridor((0.0, False, True)), QTable(), steps=2) == [(1, False), (2, False)]


# The choice.


def test_the_highest_value_is_chosen_and_chance_decides_between_equals() -> None:
    stream = random.Random(1)
    assert best_action([0, -1, 3, 2, 0, 0, 0], stream) == 2
    chosen = {best_action([1, 0, 1, 0, 0, 0, 1], stream) for _ in range(50)}
    assert chosen == {0, 2, 6}
    assert {best_action(NOTHING, stream) for _ in range(200)} == set(range(7))


def test_some_actions_are_tried_that_are_not_the_best() -> None:
    env = Corridor((0.0, False, True))
    table = QTable({state_at(0): [0, 0, 0, 1e9, 0, 0, 0]})
    run(env, table, steps=5000)
    share = sum(action != 3 for action in env.actions) / 5000
    assert share == pytest.approx(q_learning.EPSILON * 6 / 7, abs=0.02)
    assert set(env.actions) == set(range(7))


def test_no_start_of_an_examination_is_learnt_from() -> None:
    env = Corridor((0.0, False, True))
    run(env, QTable(), steps=3000)
    assert len(set(env.seeds)) > 2500
    assert max(env.seeds) < FIRST_EXAM_SEED


# What is learnt.


def learnt(steps: int, seed: int = 1, layout: Layout = ROOM) -> QTable:
    table = QTable()
    for _ in learn(table, WarehouseEnv(layout), steps, seed):
        pass
    return table


def test_the_shortest_ways_are_learnt() -> None:
    table = learnt(30_000)
    env = WarehouseEnv(ROOM)
    for seed in range(20):
        agent = QAgent(table, seed)
        agent.reset()
        observation, done = env.reset(randomize=True, seed=seed), False
        pickup, dropoff = observation["pickup_pos"], observation["dropoff_pos"]
        assert pickup is not None
        assert dropoff is not None
        shortest = distance(observation["robot_pos"], pickup) + distance(pickup, dropoff) + 2
        while not done:
            observation, _, terminated, truncated, _ = env.step(agent.act(observation))
            done = terminated or truncated
        assert (terminated, env.state.steps) == (True, shortest), seed


def distance(start: tuple[int, int], goal: tuple[int, int]) -> int:
    """Return the length of the shortest way in ``ROOM``, found by flooding it."""
    reached, length = {start}, 0
    while goal not in reached:
        length += 1
        reached |= {
            (row + down, col + right)
            for row, col in reached
            for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1))
            if ROOM.is_open((row + down, col + right))
        }
    return length


def test_the_same_seed_learns_the_same_table() -> None:
    assert learnt(2000) == learnt(2000)
    assert learnt(2000) != learnt(2000, seed=2)


def test_the_chapters_layout_is_learnt_better_than_the_greedy_agent_knows_it() -> None:
    table = learnt(450_000, layout=Task().layout)
    scores = evaluate(lambda seed: QAgent(table, seed), Task(), range(5_000_000, 5_000_100))
    assert scores.success >= 0.97
    assert scores.steps_to_deliver() < 20


# The agent.


def test_the_agent_says_what_its_action_is_worth() -> None:
    env = WarehouseEnv(ROOM, start_pos=(1, 1))
    table = QTable({((1, 1), (2, 1), False): [-1.0, 2.25, 7.04, 0.0, 0.0, 0.0, 0.0]})
    agent = QAgent(table)
    assert agent.act(env.reset()) == "S"
    assert agent.reason == "worth 7.0"
    agent.reset()
    assert agent.reason == ""


def test_an_agent_that_knows_nothing_acts_at_random_and_learns_nothing() -> None:
    observation, table = WarehouseEnv().reset(), QTable()
    agent = QAgent(table, seed=1)
    actions = [agent.act(observation) for _ in range(100)]
    assert set(actions) == set(ACTIONS)
    assert not table
    agent.reset()
    assert [agent.act(observation) for _ in range(100)] == actions
    other = QAgent(table, seed=2)
    assert [other.act(observation) for _ in range(100)] != actions
