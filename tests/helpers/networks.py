"""Networks for tests."""

from itertools import pairwise

import numpy as np

from agents.learning.map_memory import view_size
from agents.learning.policy_network import Layer, MoveNetwork, PolicyNetwork, input_size


def layers_of(*widths: int, stream: np.random.Generator) -> list[Layer]:
    """Return layers from each width to the next, with random weights."""
    return [
        (
            stream.normal(size=(outputs, inputs)).astype(np.float32),
            stream.normal(size=outputs).astype(np.float32),
        )
        for inputs, outputs in pairwise(widths)
    ]


def random_network(seed: int, view_radius: int = 2) -> PolicyNetwork:
    """Return a network with random weights."""
    stream = np.random.default_rng(seed)
    widths = input_size(view_radius), 8, 6, 7
    return PolicyNetwork(view_radius, layers_of(*widths, stream=stream))


def random_moves(seed: int, radius: int = 3, view_radius: int = 2) -> MoveNetwork:
    """Return a network of moves with random weights."""
    stream = np.random.default_rng(seed)
    return MoveNetwork(view_radius, radius, layers_of(view_size(radius), 8, 6, 1, stream=stream))


def constant_network(*logits: float, view_radius: int = 2) -> PolicyNetwork:
    """Return a network with the same seven outputs for every input."""
    size = input_size(view_radius)
    layers = [(np.zeros((5, inputs), np.float32), np.zeros(5, np.float32)) for inputs in (size, 5)]
    last = np.zeros((7, 5), np.float32), np.array(logits, np.float32)
    return PolicyNetwork(view_radius, [*layers, last])
