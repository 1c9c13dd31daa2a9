"""The network that chooses an action: two hidden layers of tanh, run by NumPy.

Training needs PyTorch (``ppo_training.py``); running needs only NumPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.learning.layers import (
    Layer,
    SingleFloats,
    checked_layers,
    load_network,
    outputs_of,
    save_layers,
)
from warehouse_core.arguments import whole_number
from warehouse_core.task.encoding import MARKED_TILES, OTHER_NUMBERS, ObservationArrays, vector
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import CELL_CODES

FORMAT = "warehouse-lab policy 1"
HEADER_KEYS = ("view_radius", "tiles")

TIMES = 2
"""Battery and steps, at the end of a vector; they are no input of a network.

The best action does not depend on them, so a network may be run with another battery than in its
training.
"""

Tiles = tuple[str, ...]
"""Tiles that a network tells apart in a window: ``MARKED_TILES``, or ``FLEET_TILES`` in a fleet."""


def network_input(arrays: ObservationArrays, tiles: Tiles = MARKED_TILES) -> SingleFloats:
    """Return the input of a network for an observation, ``[..., L]``."""
    return vector(arrays, tiles)[..., :-TIMES]


def input_size(view_radius: int, tiles: Tiles = MARKED_TILES) -> int:
    """Return ``L`` for a view radius."""
    return len(tiles) * (2 * view_radius + 1) ** 2 + OTHER_NUMBERS - TIMES


class PolicyNetwork:
    """A network of ``LAYERS`` layers with fixed weights.

    Raises:
        ValueError: the layers do not fit together or hold numbers that are not finite.
    """

    def __init__(
        self, view_radius: int, layers: Sequence[Layer], tiles: Tiles = MARKED_TILES
    ) -> None:
        self.view_radius, self.tiles = view_radius, tiles
        self.layers = checked_layers(layers, input_size(view_radius, tiles), len(ACTIONS))

    def logits(self, inputs: SingleFloats) -> SingleFloats:
        """Return ``[..., 7]`` for ``[..., L]`` inputs; the higher, the more likely is an action."""
        return outputs_of(self.layers, inputs, np.tanh)

    def save(self, path: str | Path) -> None:
        """Write the network to one ``.npz`` file, whole or not at all."""
        header = {"format": FORMAT, "view_radius": self.view_radius, "tiles": "".join(self.tiles)}
        save_layers(path, header, self.layers)

    @staticmethod
    def load(path: str | Path) -> PolicyNetwork:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        return load_network(path, FORMAT, HEADER_KEYS, _network)


def _network(header: Any, layers: list[Layer]) -> PolicyNetwork:
    radius = whole_number("view_radius", header.get("view_radius"), 0)
    tiles = header.get("tiles", "".join(MARKED_TILES))
    if not isinstance(tiles, str) or not set(tiles) <= CELL_CODES.keys():
        raise ValueError(f"tiles are {brief(tiles)}; allowed: {''.join(CELL_CODES)}")
    return PolicyNetwork(radius, layers, tuple(tiles))
