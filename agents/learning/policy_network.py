"""Networks that choose actions with NumPy, and their files.

A network has three layers with fixed weights. Training needs PyTorch, see ``ppo_training.py`` and
``clone_training.py``; running needs only NumPy. A file is a plain ``.npz`` file without pickled
objects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from agents.errors import AgentError
from agents.learning.map_memory import SingleFloats, turns, view_size
from warehouse_core import RecordError
from warehouse_core.arguments import MAX_VIEW_RADIUS, instance_of, whole_number
from warehouse_core.files.json_text import pack_header, unpack_header
from warehouse_core.files.npz import Schema, read_arrays, write_arrays
from warehouse_core.task.encoding import MARKED_TILES, OTHER_NUMBERS, ObservationArrays, vector
from warehouse_core.task.state import Observation
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import CELL_CODES

LAYERS = 3

SCHEMA: Schema = {
    "header": ("|u1", 1),
    **{f"weights_{layer}": ("<f4", 2) for layer in range(LAYERS)},
    **{f"biases_{layer}": ("<f4", 1) for layer in range(LAYERS)},
}

TIMES = 2
"""Number of values for battery and steps at the end of a vector, which networks do not get.

The best action does not depend on them. Without them, a network also works with a battery that
differs from the one in training.
"""

Layer = tuple[SingleFloats, SingleFloats]
"""Weights ``[outputs, inputs]`` and biases ``[outputs]``."""

Tiles = tuple[str, ...]
"""Tiles that a network distinguishes: ``MARKED_TILES``, or ``FLEET_TILES`` in a fleet."""


class Network:
    """Three layers with fixed weights, for a robot with a certain view radius.

    Args:
        view_radius: number of cells that the robot sees in each direction.
        layers: ``LAYERS`` layers, first to last.
        inputs: number of inputs of the first layer.
        outputs: number of outputs of the last layer.

    Raises:
        ValueError: the layers do not fit together or contain numbers that are not finite.
    """

    form: ClassVar[str]
    """Value of ``format`` in the header of a file."""

    keys: ClassVar[Mapping[str, Any]]
    """Names of the other values in the header, with defaults for older files that lack them.

    They are arguments and attributes of the network.
    """

    def __init__(
        self, view_radius: int, layers: Sequence[Layer], inputs: int, outputs: int
    ) -> None:
        self.view_radius = view_radius
        self.layers = _checked(layers, inputs, outputs)

    def check_view(self, observation: Observation, name: str) -> None:
        """Raise unless the view radius of a robot equals the one in training.

        Args:
            observation: observation of the robot.
            name: name of the network in the message.

        Raises:
            AgentError: the view radius differs from the one in training.
        """
        radius = len(observation["local_grid"]) // 2
        if radius != self.view_radius:
            raise AgentError(
                f"{name} was trained with view radius {self.view_radius}; this robot has {radius}"
            )

    def save(self, path: str | Path) -> None:
        """Write the network to a ``.npz`` file, completely or not at all."""
        header: dict[str, Any] = {"format": self.form}
        for key in self.keys:
            value = getattr(self, key)
            header[key] = "".join(value) if isinstance(value, tuple) else value
        arrays: dict[str, NDArray[Any]] = {"header": pack_header(header)}
        for number, (weights, biases) in enumerate(self.layers):
            arrays |= {f"weights_{number}": weights, f"biases_{number}": biases}
        write_arrays(path, arrays, SCHEMA)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a network that ``save`` wrote.

        Raises:
            RecordError: the file is damaged or has other contents; the message says which.
            OSError: the file cannot be read.
        """
        arrays = read_arrays(path, SCHEMA)
        layers = [(arrays[f"weights_{n}"], arrays[f"biases_{n}"]) for n in range(LAYERS)]
        try:
            header = unpack_header(arrays["header"], cls.form, tuple(cls.keys))
            given = {key: header.get(key, default) for key, default in cls.keys.items()}
            return cls(layers=layers, **given)
        except (TypeError, ValueError) as error:
            raise RecordError(f"{path}: {error}") from error

    def _activate(self, values: SingleFloats) -> SingleFloats:
        """Apply the activation function of the hidden layers, by default a rectifier."""
        return np.maximum(values, 0)

    def _outputs(self, inputs: SingleFloats) -> SingleFloats:
        """Return the outputs ``[..., M]`` for inputs ``[..., L]``."""
        *hidden, (weights, biases) = self.layers
        # OpenBLAS computes with full vector registers, and so reads past the end of a short array.
        # This may set the invalid-operation flag, although all numbers of a network are finite.
        with np.errstate(invalid="ignore"):
            for inner_weights, inner_biases in hidden:
                inputs = self._activate(inputs @ inner_weights.T + inner_biases)
            return inputs @ weights.T + biases


class PolicyNetwork(Network):
    """The network of PPO, which scores the seven actions for an observation.

    Args:
        view_radius: number of cells that the robot sees in each direction.
        layers: ``LAYERS`` layers with hyperbolic tangents between them.
        tiles: tiles that the network distinguishes.

    Raises:
        TypeError: the view radius is not an integer.
        ValueError: a value is not allowed, or the layers do not fit together or contain numbers
            that are not finite.
    """

    form = "warehouse-lab policy 1"
    keys = MappingProxyType({"view_radius": None, "tiles": MARKED_TILES})

    def __init__(
        self, view_radius: int, layers: Sequence[Layer], tiles: Tiles = MARKED_TILES
    ) -> None:
        radius = whole_number("view_radius", view_radius, 0)
        if not isinstance(tiles, str | tuple) or not set(tiles) <= CELL_CODES.keys():
            raise ValueError(f"tiles are {brief(tiles)}; allowed: {''.join(CELL_CODES)}")
        super().__init__(radius, layers, input_size(radius, tuple(tiles)), len(ACTIONS))
        self.tiles = tuple(tiles)

    def logits(self, inputs: SingleFloats) -> SingleFloats:
        """Return the scores ``[..., 7]`` for inputs ``[..., L]``; higher means likelier."""
        return self._outputs(inputs)

    def _activate(self, values: SingleFloats) -> SingleFloats:
        return np.tanh(values)


class MoveNetwork(Network):
    """The network of imitation learning, which ranks the four moves of a robot with a memory.

    The same layers score each move: their input is the view of a robot that faces in its direction.
    The network therefore applies what it has learned about one direction to all four, and can be
    small.

    Args:
        view_radius: number of cells that the robot sees in each direction.
        radius: number of cells of the robot's map in each direction that a view shows.
        layers: ``LAYERS`` layers with rectifiers between them, the last with one output.

    Raises:
        TypeError: a radius is not an integer.
        ValueError: a value is not allowed, or the layers do not fit together or contain numbers
            that are not finite.
    """

    form = "warehouse-lab moves 1"
    keys = MappingProxyType({"view_radius": None, "radius": None})

    def __init__(self, view_radius: int, radius: int, layers: Sequence[Layer]) -> None:
        whole_number("view_radius", view_radius, 0, MAX_VIEW_RADIUS)
        self.radius = whole_number("radius", radius, 0, MAX_VIEW_RADIUS)
        super().__init__(view_radius, layers, view_size(radius), 1)

    def scores(self, views: SingleFloats) -> SingleFloats:
        """Return the scores of the four moves, ``[B, 4]``, for views, ``[B, L]``."""
        return self._outputs(views[:, turns(self.radius)[0]])[..., 0]


class DriveNetwork(Network):
    """The network that controls a body: two numbers for a vector of observations.

    Args:
        backend: name of the environment for which it was trained; see ``DriveEnv.from_name``.
        layers: ``LAYERS`` layers with hyperbolic tangents between them, the last with two outputs.

    Attributes:
        inputs: length of the vector of observations.

    Raises:
        TypeError: the backend is not a name.
        ValueError: the layers do not fit together or contain numbers that are not finite.

    Example:
        >>> import numpy as np
        >>> from agents.learning import DriveNetwork
        >>> layers = [(np.zeros((b, a)), np.zeros(b)) for a, b in ((29, 8), (8, 8), (8, 2))]
        >>> DriveNetwork("drive", layers).commands(np.zeros((5, 29))).shape
        (5, 2)
    """

    form = "warehouse-lab drive 1"
    keys = MappingProxyType({"backend": None})

    def __init__(self, backend: str, layers: Sequence[Layer]) -> None:
        self.backend = instance_of("backend", backend, str)
        try:
            self.inputs = int(np.shape(layers[0][0])[-1])
        except Exception:  # a user's object may raise anything
            raise ValueError(
                f"layers is {brief(layers)}; it must be {LAYERS} pairs of weights and biases"
            ) from None
        super().__init__(0, layers, self.inputs, 2)

    def commands(self, inputs: SingleFloats) -> SingleFloats:
        """Return the actions ``[..., 2]``, from -1 to 1, for observations ``[..., L]``."""
        return np.clip(self._outputs(inputs.astype(np.float32)), -1.0, 1.0)

    def _activate(self, values: SingleFloats) -> SingleFloats:
        return np.tanh(values)


def layer_of(part: Any) -> Layer:
    """Return a copy of the weights and biases of a ``torch.nn.Linear``."""
    return part.weight.detach().numpy().copy(), part.bias.detach().numpy().copy()


def network_input(arrays: ObservationArrays, tiles: Tiles = MARKED_TILES) -> SingleFloats:
    """Return the input of a ``PolicyNetwork`` for an observation, ``[..., L]``."""
    return vector(arrays, tiles)[..., :-TIMES]


def input_size(view_radius: int, tiles: Tiles = MARKED_TILES) -> int:
    """Return ``L`` for a view radius."""
    return len(tiles) * (2 * view_radius + 1) ** 2 + OTHER_NUMBERS - TIMES


def _checked(layers: Sequence[Layer], inputs: int, outputs: int) -> list[Layer]:
    """Return the layers if they have these numbers of inputs and outputs.

    Raises:
        ValueError: the layers do not fit together or contain numbers that are not finite.
    """
    if len(layers) != LAYERS:
        raise ValueError(f"there are {len(layers)} layers; there must be {LAYERS}")
    width = inputs
    for number, (weights, biases) in enumerate(layers):
        height = outputs if number == LAYERS - 1 else len(biases)
        if weights.shape != (height, width) or biases.shape != (height,):
            raise ValueError(
                f"layer {number} has the shapes {weights.shape} and {biases.shape}; "
                f"they must be ({height}, {width}) and ({height},)"
            )
        if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
            raise ValueError(f"layer {number} has numbers that are not finite")
        width = height
    return list(layers)
