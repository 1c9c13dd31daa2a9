"""The network that ranks the four moves of a robot with a memory, run by NumPy.

The same layers judge each move: their input is the view of a robot that looks in its direction. So
what has been learned of one direction holds for all four, and the network is small.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from agents.learning.layers import (
    Layer,
    SingleFloats,
    checked_layers,
    load_network,
    outputs_of,
    rectified,
    save_layers,
)
from agents.learning.map_memory import turns, view_size
from warehouse_core.arguments import MAX_VIEW_RADIUS, whole_number

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
        self.view_radius, self.radius = view_radius, radius
        self.layers = checked_layers(layers, view_size(radius), 1)

    def scores(self, views: SingleFloats) -> SingleFloats:
        """Return how good N, E, S and W are in ``[B, L]`` views of a ``MapMemory``, ``[B, 4]``."""
        inputs = views[:, turns(self.radius)[0]]
        return outputs_of(self.layers, inputs, rectified)[..., 0]

    def save(self, path: str | Path) -> None:
        """Write the network to one ``.npz`` file, whole or not at all."""
        header = {"format": FORMAT, "view_radius": self.view_radius, "radius": self.radius}
        save_layers(path, header, self.layers)

    @staticmethod
    def load(path: str | Path) -> MoveNetwork:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        return load_network(path, FORMAT, HEADER_KEYS, _network)


def _network(header: Any, layers: list[Layer]) -> MoveNetwork:
    view_radius, radius = (
        whole_number(name, header.get(name), 0, MAX_VIEW_RADIUS) for name in HEADER_KEYS
    )
    return MoveNetwork(view_radius, radius, layers)
