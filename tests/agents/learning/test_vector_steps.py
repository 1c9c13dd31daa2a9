import numpy as np
import pytest
from numpy.typing import NDArray

from agents.learning.policy_network import network_input
from agents.learning.vector_steps import input_limits, vector_step
from warehouse_core import Layout, WarehouseEnv
from warehouse_core.batch import BatchEnv
from warehouse_core.fleet import FleetBatch
from warehouse_core.task.encoding import FLEET_TILES, encode
from warehouse_core.world.actions import ACTIONS

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
DELIVERY = ("PICK", "E", "E", "DROP")
WAITING = ("WAIT",) * 4


def room(max_steps: int) -> BatchEnv:
    """Return two rooms in which the robots start at the pickup."""
    return BatchEnv(2, ROOM, (1, 1), max_steps, randomize=False, autoreset_mode="SameStep")


def indices(*words: str) -> NDArray[np.int64]:
    return np.array([ACTIONS.index(word) for word in words])


def test_a_delivery_ends_an_episode_and_the_next_one_starts_in_the_same_step() -> None:
    batch = room(max_steps=10)
    first = network_input(batch.reset(1)[0])
    single = WarehouseEnv(ROOM)
    single.reset()
    for words in zip(DELIVERY, WAITING, strict=True):
        observations, rewards, ended, infos = vector_step(batch, indices(*words))
        last, reward, *_ = single.step(words[0])
        assert rewards.dtype == observations.dtype == np.float32
        assert rewards == pytest.approx([reward, -0.15])
        assert ended.tolist() == [words[0] == "DROP", False]
        assert infos[1] == {}
        if words[0] != "DROP":
            assert infos[0] == {}
            assert np.array_equal(observations[0], network_input(encode(last)))
    assert np.array_equal(observations[0], first[0])
    assert np.array_equal(infos[0].pop("terminal_observation"), network_input(encode(last)))
    assert infos[0] == {"TimeLimit.truncated": False, "is_success": True}
    assert not np.array_equal(network_input(encode(last)), first[0])


def test_an_episode_that_is_out_of_steps_is_truncated_unless_it_delivers_in_the_last() -> None:
    batch = room(max_steps=4)
    batch.reset(1)
    for words in zip(DELIVERY, WAITING, strict=True):
        observations, _, ended, infos = vector_step(batch, indices(*words))
    assert ended.all()
    for row, last in enumerate([(1, 3), (1, 1)]):
        final = infos[row].pop("terminal_observation")
        assert infos[row] == {"TimeLimit.truncated": row == 1, "is_success": row == 0}
        single = WarehouseEnv(ROOM)
        single.state.robot_pos = last
        assert np.array_equal(final, network_input(encode(single.observe())))
    assert np.array_equal(observations[0], observations[1])


def test_each_robot_of_a_fleet_is_a_row_until_the_fleet_restarts() -> None:
    batch = FleetBatch(2, ROOM, 2, orders=0.5, max_steps=3, autoreset_mode="SameStep")
    batch.reset(1)
    low, high = input_limits(batch)
    for step in range(3):
        observations, _, ended, infos = vector_step(batch, np.array([0, 1, 2, 3]))
        assert ((low <= observations) & (observations <= high)).all()
        assert ended.tolist() == [step == 2] * 4
    assert all(info.pop("terminal_observation").shape == low.shape for info in infos)
    assert infos == [{"TimeLimit.truncated": True}] * 4
    assert np.array_equal(observations, network_input(batch._engine.observe(), FLEET_TILES))
    assert observations.shape == (4, 7 * 25 + 9)
