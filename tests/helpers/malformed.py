"""Actions that are none, and steps with them in every environment."""

import random
from collections.abc import Callable
from itertools import cycle
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded

import warehouse_core.gymnasium_env  # noqa: F401 - registers Warehouse-v0
from warehouse_core import BatchEnv, WarehouseEnv
from warehouse_core.errors import WarehouseError

DOCUMENTED = (TypeError, ValueError, WarehouseError, ResetNeeded)


class HostileError(Exception):
    """Raised by the methods of a hostile object."""


def _raise(*_: object) -> Any:
    raise HostileError


class Hostile:
    """Raises whenever it is looked at."""

    __index__ = __int__ = __eq__ = __hash__ = __repr__ = __str__ = __len__ = _raise  # type: ignore[assignment]


class Unprintable(Hostile):
    """Is no number, and cannot be printed."""

    __index__ = None  # type: ignore[assignment]


class Liar(str):
    """A string that claims to equal everything."""

    __hash__ = str.__hash__

    def __eq__(self, other: object) -> bool:
        return True


class Wrong:
    """Has an index that is no integer."""

    def __index__(self) -> Any:
        return "N"


def deep() -> list[Any]:
    nested: list[Any] = []
    for _ in range(100_000):
        nested = [nested]
    return nested


MALFORMED: tuple[Any, ...] = (
    "", "fly", "N\x00", "\udcff", "\u0130", "x" * 10_000, b"N", bytearray(b"N"), 1.0, 1.5,
    float("nan"), float("inf"), None, -1, 7, 10**5000, -(10**5000), 2**63, 1j, [], ["N"], [0] * 100,
    (), (0, 1), {}, {"N": 0}, {0}, object(), type, len, range(3), slice(1), Ellipsis, Hostile(),
    Unprintable(), Wrong(), Liar("fly"), np.float64(1), np.float32("nan"), np.int64(-1),
    np.uint64(2**64 - 1), np.str_("fly"), np.bytes_(b"N"), np.datetime64("2020"),
    np.array(9), np.array([0, 1]), np.array("N"), np.array([None]), np.zeros((0,)),
    np.zeros((2, 2), int), np.ma.masked, deep(), memoryview(b"N"), iter([0]), Exception("N"),
    np.dtype("i4"), np.void(b"N"),
)  # fmt: skip

BATCH = 4

MALFORMED_ROWS: tuple[Any, ...] = (
    *MALFORMED, [0, 1, 2], [0, 1, 2, 7], [0, 1, 2, -1], [0.0] * 4, ["N"] * 4, [None] * 4,
    [0, 1, 2, 10**5000], [[0], [1, 2], 3, 4], [Hostile()] * 4, [Wrong()] * 4, np.zeros(4, bool),
    np.full(4, 7, np.uint8), np.full(4, -1, np.int8), np.full(4, 2**64 - 1, np.uint64),
    np.zeros((4, 1), int), np.zeros(4, "M8[s]"), np.array([0, 1, 2, None]), np.zeros(5, int),
)  # fmt: skip


class Tally(NamedTuple):
    """How steps with malformed actions ended; ``taken`` are those that count as invalid ones."""

    steps: int
    refused: int
    taken: int
    compared: int


def _warehouse(backend: str) -> tuple[Any, Callable[[], object], tuple[Any, ...]]:
    env = WarehouseEnv(backend=backend)
    env.reset(seed=1)
    return env, lambda: (env.observe(), env.layout, repr(env.last_motion)), MALFORMED


def _batch(backend: str) -> tuple[Any, Callable[[], object], tuple[Any, ...]]:
    env = BatchEnv(BATCH, backend=backend)
    env.reset(seed=1)
    return env, lambda: [env.row(row) for row in range(BATCH)], MALFORMED_ROWS


def _gymnasium(backend: str) -> tuple[Any, Callable[[], object], tuple[Any, ...]]:
    env: Any = gymnasium.make("Warehouse-v0", backend=backend, disable_env_checker=True).unwrapped
    env.reset(seed=1)
    return env, lambda: env.warehouse.observe(), MALFORMED


MAKERS = {"WarehouseEnv": _warehouse, "BatchEnv": _batch, "Warehouse-v0": _gymnasium}


def step_malformed(name: str, steps: int, seed: int, backend: str = "grid") -> Tally:
    """Step an environment with malformed actions, and now and then with a good one.

    Raises:
        AssertionError: an undocumented error, or a refused step that changed the state.
    """
    env, state, actions = MAKERS[name](backend)
    stream, refused, taken, compared = random.Random(seed), 0, 0, 0
    order = [*actions] * 20
    stream.shuffle(order)
    for number, action in zip(range(steps), cycle(order), strict=False):
        looks = number % 50 < 2 or number < len(order)
        before = state() if looks else None
        try:
            ended = env.step(action)[2:4]
            taken += 1
        except (*DOCUMENTED, HostileError):
            refused += 1
            if looks:
                compared += 1
                assert state() == before, f"{name}: {type(action).__name__} has changed the state"
            ended = (False, False)
        except Exception as error:
            raise AssertionError(f"{name}, {type(action).__name__}: {error!r}") from error
        if number % 1000 == 0 and name != "BatchEnv":
            env.reset(seed=number)
        elif number % 1000 == 500:
            env.step([number % 4] * BATCH if name == "BatchEnv" else number % 4)
        assert len(ended) == 2
    return Tally(steps, refused, taken, compared)
