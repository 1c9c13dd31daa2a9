"""Steps a second on this machine: each form of the warehouse beside something that is known.

That is an environment of Gymnasium's or MiniGrid's or, for the physics, a plainer form of its own.
Both of a pair run in turn, so that a machine that changes its pace slows both alike.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from warehouse_core import BackendError, WarehouseEnv
from warehouse_core.world.actions import ACTIONS, WAIT

Work = Callable[[], int]
"""Does a piece of work and returns how many steps that were."""

ROUNDS = 5
STEPS, FRAMES, BATCH_STEPS = 500, 50, 20
"""Of one piece of work."""

MAX_STEPS = 200
"""Of an episode, as it is where nothing else is said."""

BATCH, PHYSICS_BATCH = 4096, 256

WAREHOUSE = "warehouse_core.gymnasium_env:Warehouse-v0"
MINIGRID = "MiniGrid-Empty-8x8-v0"


@dataclass(frozen=True, slots=True)
class Pair:
    """A form of the warehouse and what it is measured beside."""

    form: str
    make: Callable[[], Work]
    beside: str
    make_beside: Callable[[], Work]


class MissingError(Exception):
    """Something that a measurement needs is not installed; the message says what installs it."""


def chapter_env(backend: str = "grid") -> Work:
    """Steps of the chapter's own environment."""
    return _stepping(WarehouseEnv(backend=backend), len(ACTIONS))


def single(name: str, actions: int, **options: Any) -> Work:
    """Steps of one environment of Gymnasium, without its wrappers."""
    return _stepping(_gymnasium().make(name, **options).unwrapped, actions)


def _stepping(env: Any, actions: int) -> Work:
    chosen = random.Random(0).choices(range(actions), k=STEPS)
    env.reset()

    def work() -> int:
        for action in chosen:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return STEPS

    return work


def frames(name: str, **options: Any) -> Work:
    """Pictures of one environment of Gymnasium, a step before each."""
    env = _gymnasium().make(name, render_mode="rgb_array", **options).unwrapped
    env.reset(seed=0)

    def work() -> int:
        for number in range(FRAMES):
            env.step(number % 3)
            env.render()
        env.reset()
        return FRAMES

    return work


def minigrid_frames() -> Work:
    """Pictures of a MiniGrid of 8 x 8 tiles."""
    try:
        import minigrid  # noqa: F401 - registers its environments
    except ImportError:
        raise MissingError(
            "minigrid is not installed: pip install 'warehouse-lab[bench]'"
        ) from None
    return frames(MINIGRID)


def carts() -> Work:
    """Steps of the batch of CartPole, whose rows fall over all by themselves."""
    env = _gymnasium().make_vec(
        "CartPole-v1", num_envs=BATCH, vectorization_mode="vector_entry_point"
    )
    env.reset(seed=0)
    return _stepping_all(env, actions=2)


def _stepping_all(env: Any, actions: int) -> Work:
    chosen = np.random.default_rng(0).integers(actions, size=(BATCH_STEPS, env.num_envs))

    def work() -> int:
        for row in chosen:
            env.step(row)
        return chosen.size

    return work


def _gymnasium() -> Any:
    import gymnasium

    return gymnasium


def _lake() -> Work:
    return single("FrozenLake-v1", actions=4)


def _warehouse(**options: Any) -> Callable[[], Work]:
    return lambda: single(WAREHOUSE, actions=len(ACTIONS), **options)


def _warehouses(rows: int, **options: Any) -> Callable[[], Work]:
    def make() -> Work:
        env = _gymnasium().make_vec(
            WAREHOUSE, num_envs=rows, vectorization_mode="vector_entry_point", **options
        )
        _put_out_of_step(env)
        return _stepping_all(env, len(ACTIONS))

    return make


def _put_out_of_step(env: Any) -> None:
    """Let some rows end and some begin with every step, as they do in a long training."""
    env.reset(seed=0)
    rows = np.arange(env.num_envs)
    for step in range(MAX_STEPS):
        env.step(np.full(env.num_envs, WAIT))
        env.reset(options={"reset_mask": rows % MAX_STEPS == step})


LAKE, CARTS, TILES = "FrozenLake-v1", "CartPole-v1, batch", "MiniGrid, pictures"
PHYSICS = "physics"

PAIRS = (
    Pair("WarehouseEnv", chapter_env, LAKE, _lake),
    Pair("Warehouse-v0", _warehouse(), LAKE, _lake),
    Pair("vectors", _warehouse(observation="vector"), LAKE, _lake),
    Pair("images", _warehouse(observation="image"), LAKE, _lake),
    Pair("pictures", lambda: frames(WAREHOUSE), TILES, minigrid_frames),
    Pair(f"batch of {BATCH:,}", _warehouses(BATCH), CARTS, carts),
    Pair("batch, no view", _warehouses(BATCH, view_radius=0), CARTS, carts),
    Pair(
        PHYSICS,
        _warehouse(backend="physics"),
        "WarehouseEnv",
        lambda: chapter_env("physics"),
    ),
    Pair(
        f"physics, batch {PHYSICS_BATCH}",
        _warehouses(PHYSICS_BATCH, backend="physics"),
        PHYSICS,
        _warehouse(backend="physics"),
    ),
)


@dataclass(frozen=True, slots=True)
class Rates:
    """Steps a second of a pair: the medians, and the median of the ratios of each round."""

    ours: float
    beside: float
    ratio: float


def measure(pair: Pair, seconds: float) -> Rates:
    """Run both of a pair in turn, each for about ``seconds`` in all.

    Raises:
        MissingError: something is not installed.
    """
    ours, beside = pair.make(), pair.make_beside()
    rates = []
    for works in [(ours, beside)] * (ROUNDS + 1):
        rates.append([_rate(work, seconds / ROUNDS) for work in works])
    del rates[0]  # the first warms up
    columns = zip(*rates, strict=True)
    mine, theirs = (median(column) for column in columns)
    return Rates(mine, theirs, median(one / other for one, other in rates))


def _rate(work: Work, seconds: float) -> float:
    steps, start = 0, perf_counter()
    while (taken := perf_counter() - start) < seconds or not steps:
        steps += work()
    return steps / taken


def bench(
    seconds: Annotated[
        float,
        typer.Option("--seconds", min=0.01, max=600, help="Time for each of the two of a pair."),
    ] = 0.5,
) -> None:
    """Print this machine's steps a second for each form, beside known environments."""
    table = Table()
    for title in ("form", "steps/s", "beside", "steps/s", "ratio"):
        table.add_column(title, justify="left" if title in ("form", "beside") else "right")
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for pair in progress.track(PAIRS, description="measuring"):
            table.add_row(*_row(pair, seconds))
    Console(markup=False).print(table)  # square brackets are those of an extra


def _row(pair: Pair, seconds: float) -> tuple[str, ...]:
    try:
        rates = measure(pair, seconds)
    except (MissingError, BackendError) as error:
        return pair.form, "", pair.beside, "", f"not measured: {error}"
    return (
        pair.form,
        f"{rates.ours:,.0f}",
        pair.beside,
        f"{rates.beside:,.0f}",
        f"{rates.ratio:.2f}",
    )
