import numpy as np
import pytest
from helpers.networks import constant_network, random_network

from agents.learning.policy_network import network_input
from agents.learning.ppo_agent import PPOAgent, useful_now
from warehouse_core import Cell, Layout, WarehouseEnv
from warehouse_core.batch import BatchEnv
from warehouse_core.task.encoding import encode
from warehouse_core.task.rules import useful_actions

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])


@pytest.mark.parametrize("layout", [None, ROOM])
@pytest.mark.parametrize("radius", [1, 2])
def test_useful_actions_follow_from_the_observation(layout: Layout | None, radius: int) -> None:
    env = WarehouseEnv(layout, view_radius=radius)
    for index in range(len(env.layout.open_cells)):
        row, col = cell = env.layout.open_cell(index)
        env.state.robot_pos = cell
        for env.state.has_item in (False, True):
            sides, tile = env.layout.open_sides(cell), env.layout.rows[row][col]
            expected = useful_actions(sides, tile, env.state.has_item)
            assert useful_now(env.observe()) == expected, cell


def test_the_useful_action_with_the_highest_output_is_chosen() -> None:
    agent = PPOAgent(constant_network(1, 2, 4, 5, 0, 7, 6))
    env = WarehouseEnv(ROOM, start_pos=(1, 1))
    assert agent.act(env.reset()) == "PICK"
    observation, *_ = env.step("PICK")
    assert agent.act(observation) == "S"  # W is a wall
    env.step("E")
    observation, *_ = env.step("E")
    assert agent.act(observation) == "DROP"
    observation, *_ = env.step("S")
    assert agent.act(observation) == "W"


def test_the_reason_is_the_probability_among_the_useful_actions_without_overflow() -> None:
    agent = PPOAgent(constant_network(9, np.log(3), -50, -50, 0, 90, 90))
    corner = WarehouseEnv(["...", "P.D"], start_pos=(0, 0))
    assert agent.act(corner.reset()) == "E"
    assert agent.reason == "75% sure"
    agent.reset()
    assert agent.reason == ""
    large = PPOAgent(constant_network(1e30, -1e30, 1e30, 0, 0, 0, 0))
    assert large.act(WarehouseEnv(ROOM, start_pos=(1, 2)).reset()) == "S"
    assert large.reason == "100% sure"


CORRIDOR = Layout(["P...D"])


def walk(agent: PPOAgent, layout: Layout, steps: int, start: Cell | None = None) -> list[str]:
    """Return the actions of an agent from a start, by default from the start of the layout."""
    env = WarehouseEnv(layout, start or layout.default_start())
    observation, actions = env.reset(), []
    agent.reset()
    for _ in range(steps):
        actions.append(agent.act(observation))
        observation, *_ = env.step(actions[-1])
    return actions


def test_a_penalty_for_visited_cells_ends_circles() -> None:
    """The network moves to and fro: it prefers E to W, and WAIT to both."""
    network = constant_network(0, 1, 0, 0, 2, 9, 9)
    assert walk(PPOAgent(network), CORRIDOR, 4) == ["PICK", "WAIT", "WAIT", "WAIT"]
    assert walk(PPOAgent(network, revisit=5), CORRIDOR, 6) == ["PICK", *"EEEE", "DROP"]


def test_visits_are_forgotten_when_the_goal_changes_and_between_episodes() -> None:
    """With the item, the robot prefers the cells that it came from to unvisited ones."""
    agent = PPOAgent(constant_network(0, 0, 0, 2, -9, 5, 5), revisit=10)
    for _ in range(2):
        assert walk(agent, Layout(["D..P", "...."]), 11, (0, 1)) == [
            *"WSEENE",
            "PICK",
            *"WWW",
            "DROP",
        ]


def test_actions_are_sampled_on_request_and_repeat_with_the_seed() -> None:
    network = constant_network(1, 1, 1, 1, 1, 1, 1)
    hall = Layout(["....."] * 5)
    first, again, other = (
        walk(PPOAgent(network, seed=s, sample=True), hall, 30) for s in (1, 1, 2)
    )
    assert first == again != other
    agent = PPOAgent(network, seed=1, sample=True)
    assert walk(agent, hall, 30) == walk(agent, hall, 30), "a reset restarts the stream"


def test_it_chooses_as_its_network_does_for_the_rows_of_a_batch() -> None:
    network = random_network(4)
    batch = BatchEnv(40)
    arrays, info = batch.reset(seed=1)
    logits = np.where(info["action_mask"], network.logits(network_input(arrays)), -np.inf)
    env = WarehouseEnv()
    for row, expected in enumerate(logits.argmax(axis=1)):
        layout, state = batch.row(row)
        observation = env.reset_to(layout, state.robot_pos)
        assert np.array_equal(network_input(encode(observation)), network_input(arrays)[row])
        assert env.ACTIONS.index(PPOAgent(network).act(observation)) == expected
