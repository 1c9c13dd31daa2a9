import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.networks import layers_of, random_moves, random_network
from helpers.training import equal

from agents.learning.policy_network import (
    MoveNetwork,
    Network,
    PolicyNetwork,
    input_size,
    network_input,
)
from warehouse_core import RecordError, WarehouseEnv
from warehouse_core.files.npz import Arrays
from warehouse_core.task.encoding import FLEET_TILES, MARKED_TILES, encode

HEADER = {"format": "warehouse-lab policy 1", "view_radius": 2, "tiles": "#PD"}


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "model.npz"
    random_network(1).save(path)
    return path


def save_changed(saved: Path, **changed: Any) -> None:
    """Rewrite the file with some of its arrays replaced."""
    with np.load(saved) as file:
        arrays: Arrays = dict(file)
    np.savez_compressed(saved, **(arrays | changed))


def refusal(saved: Path) -> str:
    with pytest.raises(RecordError) as refused:
        PolicyNetwork.load(saved)
    message = str(refused.value)
    assert message.startswith(f"{saved}: ")
    return message.removeprefix(f"{saved}: ")


def as_header(header: object) -> np.ndarray:
    return np.frombuffer(json.dumps(header).encode(), np.uint8)


# Outputs.


def test_each_layer_is_a_weighted_sum_with_tanh_except_the_last() -> None:
    network = random_network(3, view_radius=0)
    values = [0.1 * number for number in range(input_size(0))]
    for number, (weights, biases) in enumerate(network.layers):
        sums = [
            float(bias) + sum(float(w) * value for w, value in zip(row, values, strict=True))
            for row, bias in zip(weights, biases, strict=True)
        ]
        values = sums if number == 2 else [math.tanh(each) for each in sums]
    inputs = np.array([0.1 * number for number in range(input_size(0))], np.float32)
    assert network.logits(inputs) == pytest.approx(values, abs=1e-5)


def test_battery_and_steps_are_not_inputs() -> None:
    for radius in (0, 3):
        blind = WarehouseEnv(view_radius=radius).reset()
        assert network_input(encode(blind)).shape == (input_size(radius),)
    observation = WarehouseEnv().reset()
    inputs = network_input(encode(observation))
    assert inputs.shape == (input_size(2),) == (84,)
    observation["battery"], observation["steps"] = 3, 90
    assert np.array_equal(network_input(encode(observation)), inputs)
    for change in ({"has_item": True}, {"robot_pos": (2, 1)}, {"dropoff_pos": (5, 5)}):
        changed = network_input(encode(observation | change))  # type: ignore[arg-type]
        assert not np.array_equal(changed, inputs), change


@pytest.mark.parametrize(
    ("widths", "left_out", "message"),
    [
        ((83, 8, 6, 7), [], "layer 0 has the shapes"),
        ((84, 8, 6, 8), [], "layer 2 has the shapes"),
        ((84, 8, 9, 6, 7), [1], "layer 1 has the shapes"),
        ((84, 7), [], "there are 1 layers; there must be 3"),
        ((84, 8, 8, 8, 7), [], "there are 4 layers; there must be 3"),
    ],
)
def test_layers_that_do_not_fit_are_an_error(widths, left_out, message) -> None:
    layers = layers_of(*widths, stream=np.random.default_rng(1))
    with pytest.raises(ValueError, match=message):
        PolicyNetwork(2, [each for row, each in enumerate(layers) if row not in left_out])


# Its file.


@pytest.mark.parametrize(
    "network",
    [
        random_network(1),
        PolicyNetwork(1, layers_of(72, 8, 6, 7, stream=np.random.default_rng(1)), FLEET_TILES),
        random_moves(1),
    ],
)
def test_a_network_is_read_back_from_its_file(tmp_path: Path, network: Network) -> None:
    network.save(tmp_path / "n.npz")
    again = type(network).load(tmp_path / "n.npz")
    assert all(getattr(again, key) == getattr(network, key) for key in network.keys)
    assert equal(again, network)


def test_a_network_from_a_file_without_tiles_has_the_default_ones(saved: Path) -> None:
    save_changed(saved, header=as_header({key: HEADER[key] for key in ("format", "view_radius")}))
    assert PolicyNetwork.load(saved).tiles == MARKED_TILES


def test_a_file_of_the_other_kind_is_an_error(saved: Path) -> None:
    with pytest.raises(RecordError, match="its format is not"):
        MoveNetwork.load(saved)


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ([], "its header: a JSON list where there must be an object"),
        (HEADER | {"x": []}, "unknown key 'x'; allowed: view_radius, tiles"),
        (HEADER | {"format": "warehouse-lab episode 1"}, "its format is not"),
        (HEADER | {"tiles": "#?"}, "tiles are"),
        (HEADER | {"tiles": 3}, "tiles are 3"),
        ({"format": HEADER["format"]}, "view_radius is None; it must be an integer"),
        (HEADER | {"view_radius": -1}, "view_radius is -1; it must be at least 0"),
        (HEADER | {"view_radius": 2.0}, "view_radius is 2.0; "),
        (HEADER | {"view_radius": True}, "view_radius is True; "),
        (HEADER | {"view_radius": 1}, "layer 0 has the shapes (8, 84) and (8,); they must be"),
    ],
)
def test_a_wrong_header_is_an_error(saved: Path, header: object, says: str) -> None:
    save_changed(saved, header=as_header(header))
    assert refusal(saved).startswith(says)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_an_error(saved: Path, value: float) -> None:
    biases = np.zeros(7, np.float32)
    biases[3] = value
    save_changed(saved, biases_2=biases)
    assert refusal(saved) == "layer 2 has numbers that are not finite"
