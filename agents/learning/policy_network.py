"""The network that chooses an action: two hidden layers of tanh, run by NumPy.

Training needs PyTorch (``ppo_training.py``); running needs only this file. A saved network is a
plain ``.npz`` file without pickled objects.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core import RecordError
from warehouse_core.arguments import whole_number
from warehouse_core.files.header import pack_header, unpack_header
from warehouse_core.files.npz import Schema, read_arrays, write_arrays
from warehouse_core.task.encoding import MARKED_TILES, OTHER_NUMBERS, ObservationArrays, vector
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import CELL_CODES

FORMAT = "warehouse-lab policy 1"
HEADER_KEYS = ("view_radius", "tiles")
LAYERS = 3

TIMES = 2
"""Battery and steps, at the end of a vector; they are no input of a network.

The best action does not depend on them, so a network may be run with another battery than in its
training.
"""

SCHEMA: Schema = {
    "header": ("|u1", 1),
    **{f"weights_{layer}": ("<f4", 2) for layer in range(LAYERS)},
    **{f"biases_{layer}": ("<f4", 1) for layer in range(LAYERS)},
}

Tiles = tuple[str, ...]
"""Tiles that a network tells apart in a window: ``MARKED_TILES``, or ``FLEET_TILES`` in a fleet."""

SingleFloats = NDArray[np.float32]
Layer = tuple[SingleFloats, SingleFloats]
"""Weights ``[outputs, inputs]`` and biases ``[outputs]``."""


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
        self.view_radius, self.layers, self.tiles = view_radius, list(layers), tiles
        if len(self.layers) != LAYERS:
            raise ValueError(f"there are {len(self.layers)} layers; there must be {LAYERS}")
        width = input_size(view_radius, tiles)
        for number, (weights, biases) in enumerate(self.layers):
            outputs = len(ACTIONS) if number == LAYERS - 1 else len(biases)
            if weights.shape != (outputs, width) or biases.shape != (outputs,):
                raise ValueError(
                    f"layer {number} has the shapes {weights.shape} and {biases.shape}; "
                    f"they must be ({outputs}, {width}) and ({outputs},)"
                )
            if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
                raise ValueError(f"layer {number} has numbers that are not finite")
            width = outputs

    def logits(self, inputs: SingleFloats) -> SingleFloats:
        """Return ``[..., 7]`` for ``[..., L]`` inputs; the higher, the more likely is an action."""
        *hidden, (weights, biases) = self.layers
        # OpenBLAS computes whole vectors, also with what lies behind the end of a short one. That
        # may set the flag of an invalid operation, though every number of a network is finite.
        with np.errstate(invalid="ignore"):
            for inner_weights, inner_biases in hidden:
                inputs = np.tanh(inputs @ inner_weights.T + inner_biases)
            return inputs @ weights.T + biases

    def save(self, path: str | Path) -> None:
        """Write the network to one ``.npz`` file, whole or not at all."""
        header = {"format": FORMAT, "view_radius": self.view_radius, "tiles": "".join(self.tiles)}
        arrays: dict[str, NDArray[Any]] = {"header": pack_header(header)}
        for number, (weights, biases) in enumerate(self.layers):
            arrays |= {f"weights_{number}": weights, f"biases_{number}": biases}
        write_arrays(path, arrays, SCHEMA)

    @staticmethod
    def load(path: str | Path) -> PolicyNetwork:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, SCHEMA)
        layers = [(arrays[f"weights_{n}"], arrays[f"biases_{n}"]) for n in range(LAYERS)]
        try:
            header: Any = unpack_header(arrays["header"], FORMAT, HEADER_KEYS)
            radius = whole_number("view_radius", header.get("view_radius"), 0)
            tiles = header.get("tiles", "".join(MARKED_TILES))
            if not isinstance(tiles, str) or not set(tiles) <= CELL_CODES.keys():
                raise ValueError(f"tiles are {brief(tiles)}; allowed: {''.join(CELL_CODES)}")
            return PolicyNetwork(radius, layers, tuple(tiles))
        except (TypeError, ValueError) as error:
            raise RecordError(f"{path}: {error}") from error
