"""The layers of a network with fixed weights, run by NumPy, and the file that holds them.

The file is a plain ``.npz`` without pickled objects.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from warehouse_core import RecordError
from warehouse_core.files.header import pack_header, unpack_header
from warehouse_core.files.npz import Schema, read_arrays, write_arrays

LAYERS = 3

SCHEMA: Schema = {
    "header": ("|u1", 1),
    **{f"weights_{layer}": ("<f4", 2) for layer in range(LAYERS)},
    **{f"biases_{layer}": ("<f4", 1) for layer in range(LAYERS)},
}

SingleFloats = NDArray[np.float32]
Layer = tuple[SingleFloats, SingleFloats]
"""Weights ``[outputs, inputs]`` and biases ``[outputs]``."""

Network = TypeVar("Network")


def checked_layers(layers: Sequence[Layer], inputs: int, outputs: int) -> list[Layer]:
    """Return layers that lead from so many inputs to so many outputs.

    Raises:
        ValueError: the layers do not fit together or hold numbers that are not finite.
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


def outputs_of(
    layers: Sequence[Layer], inputs: SingleFloats, activate: Callable[[SingleFloats], SingleFloats]
) -> SingleFloats:
    """Return the outputs ``[..., M]`` of layers for inputs ``[..., L]``.

    Args:
        layers: the layers, first to last.
        inputs: inputs of the first layer.
        activate: function of the outputs of all layers but the last.
    """
    *hidden, (weights, biases) = layers
    # OpenBLAS computes whole vectors, also with what lies behind the end of a short one. That
    # may set the flag of an invalid operation, though every number of a network is finite.
    with np.errstate(invalid="ignore"):
        for inner_weights, inner_biases in hidden:
            inputs = activate(inputs @ inner_weights.T + inner_biases)
        return inputs @ weights.T + biases


def rectified(values: SingleFloats) -> SingleFloats:
    """Return values with 0 in place of those below it."""
    return np.maximum(values, 0)


def save_layers(path: str | Path, header: dict[str, Any], layers: Sequence[Layer]) -> None:
    """Write layers and a header to one ``.npz`` file, whole or not at all."""
    arrays: dict[str, NDArray[Any]] = {"header": pack_header(header)}
    for number, (weights, biases) in enumerate(layers):
        arrays |= {f"weights_{number}": weights, f"biases_{number}": biases}
    write_arrays(path, arrays, SCHEMA)


def load_network(
    path: str | Path,
    form: str,
    keys: Sequence[str],
    make: Callable[[Any, list[Layer]], Network],
) -> Network:
    """Read a network from a file that ``save_layers`` wrote.

    Args:
        path: path of the file.
        form: value that the ``format`` of the header must have.
        keys: other keys that the header may have.
        make: makes the network from the header and the layers.

    Raises:
        RecordError: the file is damaged or has other contents; the message says which.
        OSError: the file cannot be read.
    """
    arrays = read_arrays(path, SCHEMA)
    layers = [(arrays[f"weights_{n}"], arrays[f"biases_{n}"]) for n in range(LAYERS)]
    try:
        return make(unpack_header(arrays["header"], form, keys), layers)
    except (TypeError, ValueError) as error:
        raise RecordError(f"{path}: {error}") from error
