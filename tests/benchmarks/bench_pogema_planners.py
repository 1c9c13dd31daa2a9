"""Goals a step of our planners inside POGEMA, by its rules and its metric.

POGEMA runs in the Python of the environment variable ``POGEMA_PYTHON``, by default this one; it
needs pogema and SciPy. The map is the warehouse of POGEMA's benchmark, whose published figures are
printed beside; ``warehouse pogema`` compares with them episode by episode. Collisions are ``soft``,
a robot that is at its goal gets another, and the throughput is POGEMA's.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import ROOT

from warehouse_core.world.generators import kiva_warehouse

STEPS, SEEDS = 256, range(3)

PUBLISHED = {64: (1.96, 2.27), 128: (3.15, 3.49), 192: (3.94, 1.57)}
"""Of Follower and of RHCR, by the number of robots."""

TARGETS = {64: 2.25, 128: 4.2, 192: 6.0}
"""Of the best planner."""

PLANNERS: dict[str, tuple[str, float | str | None, dict[str, int]]] = {
    "PIBT": ("pibt", None, {}),
    "PIBT, lanes": ("pibt", 5.0, {}),
    "PIBT, learned costs": ("pibt", "learned", {}),
    "windowed, learned costs": ("windowed", "learned", {"groups": 100}),
}
"""Planner, costs and options, by name."""

Episode = Callable[..., dict[str, float]]


@pytest.fixture(scope="module")
def episode() -> Iterator[Episode]:
    """Return a function that runs an episode in POGEMA's process."""
    layout, starts, goals = kiva_warehouse()
    tiles = np.array([list(row) for row in layout.rows]).ravel()
    inside = tiles == "."
    tiles[inside], tiles[starts], tiles[goals] = "!", "@", "$"
    rows = tiles.reshape(layout.height, layout.width)
    command = [
        os.environ.get("POGEMA_PYTHON", sys.executable),
        str(Path(__file__).with_name("pogema_planner_worker.py")),
    ]
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, env=environment, **pipes) as worker:

        def ask(**given: Any) -> dict[str, float]:
            print(json.dumps(given), file=worker.stdin, flush=True)
            found: dict[str, float] = json.loads(worker.stdout.readline())
            return found

        print(json.dumps({"map": ["".join(row) for row in rows]}), file=worker.stdin, flush=True)
        yield ask
        worker.stdin.close()


@pytest.mark.parametrize("robots", PUBLISHED)
def test_goals_a_step_inside_pogema(robots: int, episode: Episode, measured) -> None:
    means, words = {}, []
    for name, (planner, costs, options) in PLANNERS.items():
        given = {"robots": robots, "steps": STEPS, "planner": planner, "costs": costs}
        runs = [episode(**given, options=options, seed=seed) for seed in SEEDS]
        rates = [run["throughput"] for run in runs]
        means[name] = np.mean(rates)
        seconds = np.mean([run["seconds"] for run in runs])
        error = 1.96 * np.std(rates, ddof=1) / len(rates) ** 0.5
        words.append(f"{name} {means[name]:.2f} ± {error:.2f} ({seconds:.1f} s an episode)")
    follower, rhcr = PUBLISHED[robots]
    measured(
        f"goals a step inside POGEMA, {robots} robots",
        f"{'; '.join(words)}; published: Follower {follower}, RHCR {rhcr}",
    )
    assert max(means.values()) >= TARGETS[robots]
