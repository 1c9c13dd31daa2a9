"""The network that ranks the moves of the robots of a fleet, run by NumPy.

The same layers judge each move of each robot by its view of the traffic.
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
from agents.learning.traffic_view import SIZE
from warehouse_core.arguments import flag

FORMAT = "warehouse-lab fleet moves 1"
HEADER_KEYS = ("lanes",)


class TrafficNetwork:
    """Layers with fixed weights, with rectified outputs between them.

    Args:
        lanes: true if the shortest ways of its robots are by the costs of lanes.
        layers: ``LAYERS`` layers, from ``SIZE`` inputs to one output.

    Raises:
        TypeError: ``lanes`` is neither true nor false.
        ValueError: the layers do not fit together or hold numbers that are not finite.
    """

    def __init__(self, lanes: bool, layers: Sequence[Layer]) -> None:
        self.lanes = flag("lanes", lanes)
        self.layers = checked_layers(layers, SIZE, 1)

    def scores(self, views: SingleFloats) -> SingleFloats:
        """Return how good the moves are of which a ``TrafficView`` has the views, ``[R, 5]``."""
        return outputs_of(self.layers, views, rectified)[..., 0]

    def save(self, path: str | Path) -> None:
        """Write the network to one ``.npz`` file, whole or not at all."""
        save_layers(path, {"format": FORMAT, "lanes": self.lanes}, self.layers)

    @staticmethod
    def load(path: str | Path) -> TrafficNetwork:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        return load_network(path, FORMAT, HEADER_KEYS, _network)


def _network(header: Any, layers: list[Layer]) -> TrafficNetwork:
    return TrafficNetwork(header.get("lanes"), layers)
