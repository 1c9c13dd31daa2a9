"""Functions on arrays that Numba compiles if it is installed.

A kernel allocates no memory and never looks at the clock. Its caller makes the arrays. It is
compiled for the types in its annotations when it is first needed, and cached on disk for other
processes. Its results are the same with and without Numba, bit for bit. ``WAREHOUSE_FAST=0`` in the
environment disables Numba.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property, update_wrapper
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeAlias, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np

IS_COMPILED = os.environ.get("WAREHOUSE_FAST") != "0" and find_spec("numba") is not None
"""True if kernels are compiled."""

Kernel = TypeVar("Kernel", bound=Callable[..., Any])
Scalar = TypeVar("Scalar", bound=np.generic)

Vector: TypeAlias = np.ndarray[tuple[int], np.dtype[Scalar]]
Matrix: TypeAlias = np.ndarray[tuple[int, int], np.dtype[Scalar]]
Block: TypeAlias = np.ndarray[tuple[int, int, int], np.dtype[Scalar]]
"""Arrays of kernels with one, two and three dimensions, contiguous in memory."""


class CompiledKernel:
    """A kernel that Numba compiles on its first call, together with the kernels that it calls."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        update_wrapper(self, function)

    @cached_property
    def dispatcher(self) -> Any:
        """The kernel, compiled for the types in its annotations."""
        numba: Any = import_module("numba")
        hints = get_type_hints(self._function)
        result = _type_of(hints.pop("return"))
        types = result(*map(_type_of, hints.values()))
        # Kernels allocate nothing, and are several times as fast without reference counting.
        return numba.njit(types, cache=True, error_model="numpy", _nrt=False)(self._function)

    @cached_property
    def compiled(self) -> Any:
        """The compiled function, which does not check its arguments.

        Checking takes a quarter of a microsecond per array of a named tuple, longer than many
        kernels need.
        """
        [result] = self.dispatcher.overloads.values()
        return result.entry_point

    @property
    def _numba_type_(self) -> Any:
        """Numba's type of this kernel when another kernel calls it."""
        types: Any = import_module("numba").types
        return types.Dispatcher(self.dispatcher)

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel with arguments of the types in its annotations."""
        return self.compiled(*arguments)


def kernel(function: Kernel) -> Kernel:
    """Return a function on arrays and numbers, compiled if Numba is installed.

    Its annotations are the types that it is compiled for: ``int``, ``bool``, ``Vector``,
    ``Matrix``, ``Block``, ``list[int]`` and ``memoryview`` for arrays of 64 and 32 bits, and named
    tuples.
    """
    return cast(Kernel, CompiledKernel(function)) if IS_COMPILED else function


def prepare(*kernels: Callable[..., Any]) -> None:
    """Compile kernels now, so that the first call takes no longer than later ones."""
    for each in kernels:
        if isinstance(each, CompiledKernel):
            each.compiled  # noqa: B018


def _type_of(hint: Any) -> Any:
    """Return Numba's type for an annotation."""
    numba: Any = import_module("numba")
    types = numba.types
    if get_origin(hint) is np.ndarray:
        shape, numbers = get_args(hint)
        [number] = get_args(numbers)
        return types.Array(numba.from_dtype(np.dtype(number)), len(get_args(shape)), "C")
    if hint == list[int]:
        return types.int64[::1]
    if hint is memoryview:
        return types.int32[::1]
    if hasattr(hint, "_fields"):
        each = [_type_of(field) for field in get_type_hints(hint).values()]
        if len(set(each)) == 1:
            return types.NamedUniTuple(each[0], len(each), hint)
        return types.NamedTuple(each, hint)
    return {int: types.int64, bool: types.boolean, type(None): types.void}[hint]
