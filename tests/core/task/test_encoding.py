from typing import Any

import numpy as np
import pytest

from warehouse_core import WarehouseEnv
from warehouse_core.task.encoding import NOWHERE, encode, vector, vector_limits
from warehouse_core.task.state import Observation

EAST, WEST, PICK = 1, 3, 5


def observation(**changes: Any) -> Observation:
    seen: Any = {
        "local_grid": ["#P.", "#rD", "..."],
        "robot_pos": (4, 7),
        "has_item": True,
        "battery": 50,
        "steps": 150,
        "pickup_pos": (3, 7),
        "dropoff_pos": (4, 8),
    }
    return seen | changes


def test_an_observation_is_encoded_key_by_key() -> None:
    arrays = encode(observation())
    assert list(arrays) == list(observation())
    assert arrays["local_grid"].tolist() == [1, 2, 0, 1, 5, 3, 0, 0, 0]
    assert arrays["local_grid"].dtype == np.uint8
    expected = {"robot_pos": [4, 7], "pickup_pos": [3, 7], "dropoff_pos": [4, 8]}
    for key, values in (expected | {"battery": [50], "steps": [150]}).items():
        assert arrays[key].tolist() == values
        assert arrays[key].dtype == np.int32
    assert arrays["has_item"] == 1
    assert type(arrays["has_item"]) is int
    assert encode(observation(local_grid=["R"]))["local_grid"].tolist() == [4]


def test_a_missing_station_is_nowhere() -> None:
    arrays = encode(observation(pickup_pos=None, dropoff_pos=None))
    assert arrays["pickup_pos"].tolist() == arrays["dropoff_pos"].tolist() == list(NOWHERE)
    assert encode(observation(pickup_pos=(0, 0)))["pickup_pos"].tolist() == [0, 0]


# As one vector.


def test_a_vector_has_the_numbers_of_its_table() -> None:
    window = [1, 0, 0, 0, 1, 0, 0, 0, 0]  # of "#P.": wall, pickup, dropoff for each cell
    window += [1, 0, 0, 0, 0, 0, 0, 0, 1]  # "#rD": the robot is none of the three
    window += [0] * 9
    numbers = [0.4, 0.7, 1, -0.1, 0.0, 1, 0.0, 0.1, 1, 0.5, 1.5]
    found = vector(encode(observation()))
    assert found.dtype == np.float32
    assert found.tolist() == pytest.approx(window + numbers, abs=1e-7)
    far = observation(pickup_pos=(0, 27), has_item=False)
    assert vector(encode(far))[27:].tolist() == pytest.approx(
        [0.4, 0.7, 1, -0.4, 2.0, 1, 0.0, 0.1, 0, 0.5, 1.5]
    )


def test_the_limits_of_a_vector_are_exact() -> None:
    low, high = vector_limits(height=31, width=6, view_radius=0, battery=70, max_steps=90)
    assert (low.dtype, high.dtype) == (np.float32, np.float32)
    assert low.tolist() == pytest.approx([0] * 3 + [0, 0, 0, -3, -0.5, 0, -3, -0.5, 0, 0, 0])
    assert high.tolist() == pytest.approx([1] * 3 + [3, 0.5, 1, 3, 0.5, 1, 3, 0.5, 1, 0.7, 0.9])
    corners: Any = {"local_grid": ["r"], "has_item": True, "battery": 70, "steps": 90}
    last = observation(**corners, robot_pos=(30, 5), pickup_pos=(0, 0), dropoff_pos=(30, 5))
    first = observation(**corners, robot_pos=(0, 0), pickup_pos=(30, 5), dropoff_pos=(0, 0))
    for seen in map(vector, map(encode, (last, first))):
        assert (low <= seen).all()
        assert (seen <= high).all()
    assert np.array_equal(
        vector(encode(last))[[3, 4, 6, 7, 11, 12, 13]],
        [*high[[3, 4]], *low[[6, 7]], *high[[11, 12, 13]]],
    )


def test_tiles_of_a_fleet_have_codes_of_their_own_in_a_window() -> None:
    observation = WarehouseEnv(["...", "...", "..."], (1, 1), view_radius=1).reset()
    observation["local_grid"] = ["CO.", "HRo", "#PD"]
    assert encode(observation)["local_grid"].tolist() == [6, 7, 0, 9, 4, 8, 1, 2, 3]
