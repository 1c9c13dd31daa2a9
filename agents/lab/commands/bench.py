"""Measure the steps per second of each form of the warehouse on this machine.

Each is measured beside a known environment of Gymnasium or MiniGrid or, for physics, beside a
simpler form. The two of a pair take turns, so that a change of the machine's speed affects both.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from time import perf_counter
from typing import Annotated, Any

import numpy as np
import typer

from agents.lab.console.table import Table, print_table
from warehouse_core import BackendError, WarehouseEnv
from warehouse_core.extras import install_command
from warehouse_core.world.actions import ACTIONS, WAIT

Work = Callable[[], int]
"""Takes some steps and returns how many."""

ROUNDS = 5
STEPS, FRAMES, BATCH_STEPS = 500, 50, 20
"""How many of them a ``Work`` takes."""

MAX_STEPS = 200
"""Steps of an episode, the default of the environments."""

BATCH, PHYSICS_BATCH = 4096, 256

WAREHOUSE = "warehouse_core.gymnasium_env:Warehouse-v0"
LAKE, CARTS, MINIGRID = "FrozenLake-v1", "CartPole-v1", "MiniGrid-Empty-8x8-v0"


@dataclass(frozen=True, slots=True)
class Pair:
    """A form of the warehouse and what it is measured beside."""

    form: str
    make: Callable[[], Work]
    beside: str
    make_beside: Callable[[], Work]


def chapter_env(backend: str = "grid") -> Work:
    """Return the work of stepping the chapter's own environment."""
    return _stepping(WarehouseEnv(backend=backend), len(ACTIONS))


def single(name: str, **options: Any) -> Work:
    """Return the work of stepping an environment of Gymnasium, without its wrappers."""
    env = _gymnasium().make(name, **options).unwrapped
    return _stepping(env, env.action_space.n)


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


def frames(name: str) -> Work:
    """Return the work of stepping and drawing an environment of Gymnasium."""
    env = _gymnasium().make(name, render_mode="rgb_array").unwrapped
    env.reset(seed=0)

    def work() -> int:
        for number in range(FRAMES):
            env.step(number % 3)
            env.render()
        env.reset()
        return FRAMES

    return work


def minigrid_frames() -> Work:
    """Return the work of stepping and drawing a MiniGrid of 8 x 8 tiles.

    Raises:
        ImportError: MiniGrid is not installed.
    """
    try:
        import minigrid  # noqa: F401 - registers its environments
    except ImportError:
        raise ImportError(f"minigrid is not installed: {install_command('bench')}") from None
    return frames(MINIGRID)


def batch(name: str, rows: int, **options: Any) -> Work:
    """Return the work of stepping a vector environment of Gymnasium."""
    env = _gymnasium().make_vec(
        name, num_envs=rows, vectorization_mode="vector_entry_point", **options
    )
    env.reset(seed=0)
    if name == WAREHOUSE:
        _stagger(env)
    actions = env.single_action_space.n
    chosen = np.random.default_rng(0).integers(actions, size=(BATCH_STEPS, rows))

    def work() -> int:
        for row in chosen:
            env.step(row)
        return chosen.size

    return work


def _stagger(env: Any) -> None:
    """Let some rows end and restart at every step, as in a long training."""
    rows = np.arange(env.num_envs)
    for step in range(MAX_STEPS):
        env.step(np.full(env.num_envs, WAIT))
        env.reset(options={"reset_mask": rows % MAX_STEPS == step})


def _gymnasium() -> Any:
    import gymnasium

    return gymnasium


_lake = partial(single, LAKE)
_carts = partial(batch, CARTS, BATCH)
_physics = partial(single, WAREHOUSE, backend="physics")

PAIRS = (
    Pair("WarehouseEnv", chapter_env, LAKE, _lake),
    Pair("Warehouse-v0", partial(single, WAREHOUSE), LAKE, _lake),
    Pair("vectors", partial(single, WAREHOUSE, observation="vector"), LAKE, _lake),
    Pair("images", partial(single, WAREHOUSE, observation="image"), LAKE, _lake),
    Pair("pictures", partial(frames, WAREHOUSE), "MiniGrid, pictures", minigrid_frames),
    Pair(f"batch of {BATCH:,}", partial(batch, WAREHOUSE, BATCH), f"{CARTS}, batch", _carts),
    Pair(
        "batch, no view",
        partial(batch, WAREHOUSE, BATCH, view_radius=0),
        f"{CARTS}, batch",
        _carts,
    ),
    Pair("physics", _physics, "WarehouseEnv", partial(chapter_env, "physics")),
    Pair(
        f"physics, batch {PHYSICS_BATCH}",
        partial(batch, WAREHOUSE, PHYSICS_BATCH, backend="physics"),
        "physics",
        _physics,
    ),
)


@dataclass(frozen=True, slots=True)
class Rates:
    """Steps per second of a pair: both medians, and the median of the ratios of the rounds."""

    ours: float
    beside: float
    ratio: float


def measure(pair: Pair, seconds: float) -> Rates:
    """Run both works of a pair in turn, each for about ``seconds`` in total.

    Raises:
        ImportError: something is not installed.
    """
    works = pair.make(), pair.make_beside()
    rates = [[_rate(work, seconds / ROUNDS) for work in works] for _ in range(ROUNDS + 1)]
    del rates[0]  # the warm-up
    ours, beside = (median(column) for column in zip(*rates, strict=True))
    return Rates(ours, beside, median(one / other for one, other in rates))


def _rate(work: Work, seconds: float) -> float:
    steps, start = 0, perf_counter()
    while (taken := perf_counter() - start) < seconds or not steps:
        steps += work()
    return steps / taken


def bench(
    seconds: Annotated[
        float,
        typer.Option("--seconds", min=0.01, max=600, help="Seconds to measure each environment."),
    ] = 0.5,
) -> None:
    """Measure the steps per second on this machine.

    Each form of the warehouse is measured beside a known environment.

    Example: warehouse bench --seconds 2
    """
    from agents.lab.console.progress import track

    rows = [_row(pair, seconds) for pair in track(PAIRS, "measuring")]
    header = ("form", "steps/s", "beside", "steps/s", "ratio")
    print_table(
        Table(
            header,
            rows,
            caption=f"medians of {ROUNDS} rounds; the ratio is the median "
            "of their ratios, not the ratio of the medians",
        )
    )


def _row(pair: Pair, seconds: float) -> tuple[str, ...]:
    try:
        rates = measure(pair, seconds)
    except (ImportError, BackendError) as error:
        return pair.form, "", pair.beside, "", f"not measured: {error}"
    ours, beside = f"{rates.ours:,.0f}", f"{rates.beside:,.0f}"
    return pair.form, ours, pair.beside, beside, f"{rates.ratio:.2f}"
