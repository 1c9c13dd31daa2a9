"""Rows of sweeps that are killed, reports on large sweeps, and coverage of intervals.

``WAREHOUSE_PYTHONS`` names the interpreters that run sweeps, separated as in ``PATH``. The package
must be installed for each of them with the extra ``physics``. Default: the running interpreter.
"""

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.sweeps import FLAGS, Sweep, kill_sweeps, table, uninterrupted

from agents import GreedyAgent
from agents.lab.trials.interval import CONFIDENCE, mean_interval, ratio_interval
from warehouse_core import WarehouseEnv, record_episode
from warehouse_core.records.episode import DELIVERED

# Rows of sweeps that are killed.

PYTHONS = os.environ.get("WAREHOUSE_PYTHONS", sys.executable).split(os.pathsep)
KILLED = {"lone robots": (100, 6_000, FLAGS), "fleets": (100, 1_500, [
    "robots=2,4", "planner=pibt", "order_rate=0.2", "max_steps=100", "battery=60",
])}  # fmt: skip
"""Number of kills, number of episodes of each case, and settings of the sweeps that are killed."""

EARLY_SHARE = 0.5
"""Share of the episodes that are stored before the first kill, so that late kills occur too."""
SECONDS = 600
"""Maximum duration of a sweep in seconds."""


def version_of(python: str) -> str:
    words = [python, "-c", "import platform; print(platform.python_version())"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def compared(path: Path, expected: list) -> tuple[int, int, int]:
    """Return the numbers of rows that are lost, duplicated and different."""
    found, wanted = table(path), dict(keyed(expected))
    counts = Counter(key for key, _ in keyed(found))
    differing = sum(wanted[key] != row for key, row in keyed(found))
    return len(wanted.keys() - counts.keys()), counts.total() - len(counts), differing


def keyed(rows: list) -> list:
    return [(row[:2], row) for row in rows]


@pytest.mark.parametrize("python", PYTHONS, ids=version_of)
@pytest.mark.parametrize("kind", KILLED)
def test_kill_9(tmp_path, measured, kind: str, python: str) -> None:
    kills, episodes, flags = KILLED[kind]
    path = tmp_path / "r.sqlite"
    assert Sweep(path, int(EARLY_SHARE * episodes), flags, python=python).end(SECONDS)[0] == 0
    begun = len(table(path))
    killed = kill_sweeps(path, episodes, kills, flags, python)
    left = len(table(path))
    assert Sweep(path, episodes, flags, python=python).end(SECONDS)[0] == 0
    expected = uninterrupted(tmp_path / "expected.sqlite", episodes, flags)
    lost, duplicated, different = compared(path, expected)
    measured(
        f"a sweep of {kind}, killed {kills} times with SIGKILL, Python {version_of(python)}",
        f"{killed} kills while it ran, with {begun:,} to {left:,} of {len(expected):,} rows: "
        f"{lost} rows lost, {duplicated} duplicated, {different} different",
    )
    assert (lost, duplicated, different) == (0, 0, 0)


# Intervals.

SAMPLED, TRIALS, SIZES = 5000, 1000, (20, 50, 100, 300)
LOWEST = 0.9


def sampled() -> np.ndarray:
    """Return the number of steps and the success (1 or 0) of episodes, ``[n, 2]``."""
    env = WarehouseEnv()
    found = [record_episode(env, GreedyAgent(seed), seed=seed) for seed in range(SAMPLED)]
    return np.array([(each.steps, each.outcome == DELIVERED) for each in found], float)


def coverage(sample: Callable[[], tuple[float, float]], truth: float) -> float:
    """Return the share of sampled intervals that contain ``truth``."""
    ends = np.array([sample() for _ in range(TRIALS)])
    return float(np.mean((ends[:, 0] <= truth) & (truth <= ends[:, 1])))


def test_intervals_contain_the_true_value_about_as_often_as_they_say(measured) -> None:
    stream = np.random.default_rng(0)
    found = sampled()
    steps, delivered = found.T
    populations = {
        "steps of an episode": steps,
        "steps of a delivery": steps[delivered == 1],
        "lognormal": stream.lognormal(0, 1, 200_000),
    }

    def means(values: np.ndarray, size: int) -> tuple[float, float]:
        interval = mean_interval(stream.choice(values, size))
        return interval.low, interval.high

    def ratios(size: int) -> tuple[float, float]:
        interval = ratio_interval(*stream.choice(found, size).T)
        return interval.low, interval.high

    shares = {}
    for size in SIZES:
        for name, values in populations.items():
            shares[name, size] = coverage(lambda v=values, n=size: means(v, n), values.mean())
    for size in SIZES[1:]:  # 20 episodes have fewer than the 20 deliveries that are needed
        shares["steps per delivery", size] = coverage(
            lambda n=size: ratios(n), steps.sum() / delivered.sum()
        )
    for (name, size), share in shares.items():
        measured(
            f"{CONFIDENCE:.0%} intervals that contain the true value: {name}, n = {size}",
            f"{share:.1%}",
        )
    assert min(shares.values()) >= LOWEST
