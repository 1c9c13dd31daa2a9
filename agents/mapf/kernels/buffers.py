"""Flat buffers, and the functions on them that Numba compiles if it is installed.

With Numba, buffers are arrays. Kernels are compiled for exactly these types when they are first
needed, and cached on disk for other processes. Without Numba, buffers are lists, because plain
Python reads lists faster than arrays. Kernels use whole numbers only, so that both give the same
results bit for bit. ``WAREHOUSE_FAST=0`` in the environment disables Numba.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property, update_wrapper
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeAlias, TypeVar, cast, get_type_hints

import numpy as np
from numpy.typing import NDArray

IS_COMPILED = os.environ.get("WAREHOUSE_FAST") != "0" and find_spec("numba") is not None
"""True if kernels are compiled."""

Buffer: TypeAlias = list[int]
"""Buffer of 64-bit numbers: a list, or an array if kernels are compiled."""

Table: TypeAlias = memoryview
"""Large buffer of 32-bit numbers: a view of an array, or the array itself if compiled."""

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def buffer(size: int, value: int = 0) -> Buffer:
    """Return a buffer filled with one number."""
    return cast(Buffer, np.full(size, value, np.int64)) if IS_COMPILED else [value] * size


def buffer_of(numbers: NDArray[np.integer]) -> Buffer:
    """Return a buffer with a copy of the numbers of an array."""
    flat = numbers.ravel()
    return cast(Buffer, flat.astype(np.int64)) if IS_COMPILED else flat.tolist()


def table_of(numbers: NDArray[np.int32]) -> Table:
    """Return a table that shares the memory of a contiguous array."""
    flat = numbers.reshape(-1)
    return cast(Table, flat) if IS_COMPILED else memoryview(cast(Any, flat))


def enlarged(old: Buffer, size: int, value: int = 0) -> Buffer:
    """Return a longer buffer that begins with the numbers of another."""
    if not IS_COMPILED:
        return [*old, *[value] * (size - len(old))]
    new = np.full(size, value, np.int64)
    new[: len(old)] = old
    return cast(Buffer, new)


class CompiledKernel:
    """A kernel that Numba compiles on its first call, together with the kernels that it calls."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        update_wrapper(self, function)

    @cached_property
    def compiled(self) -> Any:
        """The kernel, compiled for the types in its annotations."""
        numba: Any = import_module("numba")
        hints = get_type_hints(self._function)
        result = _type_of(hints.pop("return"))
        types = result(*map(_type_of, hints.values()))
        # Kernels allocate nothing, and are several times as fast without reference counting.
        return numba.njit(types, cache=True, error_model="numpy", _nrt=False)(self._function)

    @property
    def _numba_type_(self) -> Any:
        """Numba's type of this kernel when another kernel calls it."""
        types: Any = import_module("numba").types
        return types.Dispatcher(self.compiled)

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel with buffers, tables and whole numbers."""
        return self.compiled(*arguments)


def kernel(function: Kernel) -> Kernel:
    """Return a function on buffers, tables and whole numbers, compiled if Numba is installed.

    Its annotations are the types that it is compiled for. Named tuples of these types are allowed.
    """
    return cast(Kernel, CompiledKernel(function)) if IS_COMPILED else function


def prepare(*kernels: Callable[..., Any]) -> None:
    """Compile kernels now, so that the first call takes no longer than later ones."""
    for each in kernels:
        if isinstance(each, CompiledKernel):
            each.compiled  # noqa: B018


def _type_of(hint: Any) -> Any:
    """Return Numba's type for an annotation."""
    types: Any = import_module("numba").types
    if hint == Buffer:
        return types.int64[::1]
    if hint is memoryview:
        return types.int32[::1]
    if hasattr(hint, "_fields"):
        each = [_type_of(field) for field in get_type_hints(hint).values()]
        if len(set(each)) == 1:
            return types.NamedUniTuple(each[0], len(each), hint)
        return types.NamedTuple(each, hint)
    return {int: types.int64, bool: types.boolean, type(None): types.void}[hint]
