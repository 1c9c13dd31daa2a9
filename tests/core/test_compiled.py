"""Kernels are compiled for the types in their annotations; here with a stand-in for Numba."""

import sys
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from warehouse_core import compiled
from warehouse_core.compiled import Matrix, Vector, kernel, prepare


class Pair(NamedTuple):
    first: Vector[np.int32]
    second: Vector[np.int32]


class Mixed(NamedTuple):
    numbers: list[int]
    table: memoryview
    count: int


class Type(str):
    """A name of a type, from which signatures and arrays can be made as from Numba's types."""

    def __getitem__(self, _: slice) -> "Type":
        return Type(f"{self}[]")

    def __call__(self, *types: str) -> tuple[str, ...]:
        return (self, *types)


@pytest.fixture
def numba(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Install the stand-in, and return the list of the signatures that it compiles."""
    module, signatures = ModuleType("numba"), list[Any]()

    def njit(signature: Any, **options: Any) -> Any:
        assert options == {"cache": True, "error_model": "numpy", "_nrt": False}
        signatures.append(signature)
        return lambda function: SimpleNamespace(
            overloads={signature: SimpleNamespace(entry_point=function)}
        )

    module.njit = njit  # type: ignore[attr-defined]
    module.from_dtype = lambda dtype: dtype.name  # type: ignore[attr-defined]
    module.types = SimpleNamespace(  # type: ignore[attr-defined]
        int64=Type("int64"), int32=Type("int32"), boolean=Type("boolean"), void=Type("void"),
        Array=lambda *parts: parts, Dispatcher=lambda dispatcher: ("calls", dispatcher),
        NamedUniTuple=lambda each, count, kind: (each, count, kind.__name__),
        NamedTuple=lambda each, kind: (*each, kind.__name__),
    )  # fmt: skip
    monkeypatch.setitem(sys.modules, "numba", module)
    monkeypatch.setattr(compiled, "IS_COMPILED", True)
    return signatures


def first_of(pair: Pair, mixed: Mixed, places: Matrix[np.bool_], flag: bool) -> int:
    return int(pair.first[0]) + mixed.count


def nothing(number: int) -> None:
    return None


def test_a_kernel_is_compiled_once_for_the_types_in_its_annotations(numba: list[Any]) -> None:
    made: Any = kernel(first_of)
    assert numba == []  # importing a module with kernels compiles none of them
    pair, mixed = Pair(*np.array([[3], [4]], np.int32)), Mixed([1], memoryview(b""), 5)
    for _ in range(2):
        assert made(pair, mixed, np.zeros((1, 2), np.bool_), True) == 8
    assert numba == [
        (
            "int64",
            (("int32", 1, "C"), 2, "Pair"),
            ("int64[]", "int32[]", "int64", "Mixed"),
            ("bool", 2, "C"),
            "boolean",
        )
    ]
    assert made._numba_type_ == ("calls", made.dispatcher)


def test_kernels_can_be_compiled_before_they_are_called(numba: list[Any]) -> None:
    prepare(nothing, kernel(nothing))
    assert numba == [("void", "int64")]


def test_without_numba_a_kernel_is_the_function_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "IS_COMPILED", False)
    assert kernel(nothing) is nothing
