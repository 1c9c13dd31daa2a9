"""Flat buffers of kernels, see ``warehouse_core/compiled.py``.

With Numba, buffers are arrays. Without Numba, buffers are lists, because plain Python reads lists
faster than arrays. Kernels use whole numbers only, so that both give the same results bit for bit.
"""

from __future__ import annotations

from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.compiled import IS_COMPILED

Buffer: TypeAlias = list[int]
"""Buffer of 64-bit numbers: a list, or an array if kernels are compiled."""

Table: TypeAlias = memoryview
"""Large buffer of 32-bit numbers: a view of an array, or the array itself if compiled."""


def buffer(size: int, value: int = 0) -> Buffer:
    """Return a buffer filled with one number."""
    return cast(Buffer, np.full(size, value, np.int64)) if IS_COMPILED else [value] * size


def buffer_of(numbers: NDArray[np.integer]) -> Buffer:
    """Return a buffer with a copy of the numbers of an array."""
    flat = numbers.ravel()
    return cast(Buffer, flat.astype(np.int64)) if IS_COMPILED else flat.tolist()


def write(record: Any, **numbers: NDArray[Any]) -> None:
    """Write whole numbers or flags into buffers of a record, by the names of the buffers."""
    for name, each in numbers.items():
        getattr(record, name)[:] = buffer_of(each.astype(np.int64))


def table_of(numbers: NDArray[np.int32]) -> Table:
    """Return a table that shares the memory of a contiguous array."""
    flat = numbers.reshape(-1)
    return cast(Table, flat) if IS_COMPILED else memoryview(cast(Any, flat))


def enlarged(old: Buffer, size: int) -> Buffer:
    """Return a longer buffer that begins with the numbers of another, followed by zeros."""
    new = buffer(size)
    new[: len(old)] = old
    return new
