"""The network that ranks the four moves of a robot with a memory, run by NumPy.

The same layers judge each move: their input is the view of a robot that looks in its direction. So
what has been learned of one direction holds for all four, and the network is small.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.learning.map_memory import SingleFloats, turns, view_size
from agents.learning.policy_network import LAYERS, SCHEMA, Layer
from warehouse_core import RecordError
from warehouse_core.arguments import MAX_VIEW_RADIUS, whole_number
from warehouse_core.files.header import pack_header, unpack_header
from warehouse_core.files.npz import read_arrays, write_arrays

FORMAT = "warehouse-lab moves 1"
HEADER_KEYS = ("view_radius", "radius")


class MoveNetwork:
    """Layers with fixed weights, with rectified outputs between them.

    Args:
        view_radius: cells that the robot sees in each direction.
        radius: cells of its map in each direction that it is shown.
        layers: ``LAYERS`` layers, the last with one output.

    Raises:
        ValueError: the layers do not fit together or hold numbers that are not finite.
    """

    def __init__(self, view_radius: int, radius: int, layers: Sequence[Layer]) -> None:
        self.view_radius, self.radius, self.layers = view_radius, radius, list(layers)
        width = view_size(radius)
        for number, (weights, biases) in enumerate(self.layers):
            outputs = 1 if number == LAYERS - 1 else len(biases)
            if weights.shape != (outputs, width) or biases.shape != (outputs,):
                raise ValueError(
                    f"layer {number} has the shapes {weights.shape} and {biases.shape}; "
                    f"they must be ({outputs}, {width}) and ({outputs},)"
                )
            if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
                raise ValueError(f"layer {number} has numbers that are not finite")
            width = outputs

    def scores(self, views: SingleFloats) -> SingleFloats:
        """Return how good N, E, S and W are in ``[B, L]`` views of a ``MapMemory``, ``[B, 4]``."""
        inputs = views[:, turns(self.radius)[0]]
        *hidden, (weights, biases) = self.layers
        # See ``PolicyNetwork.logits`` for the flag of an invalid operation.
        with np.errstate(invalid="ignore"):
            for inner_weights, inner_biases in hidden:
                inputs = np.maximum(inputs @ inner_weights.T + inner_biases, 0)
            found: SingleFloats = (inputs @ weights.T + biases)[..., 0]
        return found

    def save(self, path: str | Path) -> None:
        """Write the network to one ``.npz`` file, whole or not at all."""
        header = {"format": FORMAT, "view_radius": self.view_radius, "radius": self.radius}
        arrays: dict[str, NDArray[Any]] = {"header": pack_header(header)}
        for number, (weights, biases) in enumerate(self.layers):
            arrays |= {f"weights_{number}": weights, f"biases_{number}": biases}
        write_arrays(path, arrays, SCHEMA)

    @staticmethod
    def load(path: str | Path) -> MoveNetwork:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, SCHEMA)
        layers = [(arrays[f"weights_{n}"], arrays[f"biases_{n}"]) for n in range(LAYERS)]
        try:
            header: Any = unpack_header(arrays["header"], FORMAT, HEADER_KEYS)
            view_radius, radius = (
                whole_number(name, header.get(name), 0, MAX_VIEW_RADIUS) for name in HEADER_KEYS
            )
            return MoveNetwork(view_radius, radius, layers)
        except (TypeError, ValueError) as error:
            raise RecordError(f"{path}: {error}") from error
