"""Decisions a second of PIBT, and those of pypibt in the same run; ten thousand robots.

The folder of pypibt's repository is the environment variable ``PYPIBT``. Both begin with all
distances known, and lead the same robots from the same starts to the same goals.
"""

import importlib
import os
import time
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import big_warehouse

from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.planner import NO_CELLS, Situation
from warehouse_core import Layout, random_layout

ROUNDS, STEPS = 7, 40


def draw(layout: Layout, robots: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts and goals."""
    stream = np.random.default_rng(0)
    cells, goals = (stream.permutation(layout.open_cells)[:robots] for _ in range(2))
    return cells, goals


def seconds_of(planner: PIBT, cells: np.ndarray, goals: np.ndarray) -> list[float]:
    """Return the processor time of each step."""
    nobody, times = np.zeros(len(cells), np.bool_), []
    for _ in range(STEPS):
        start = time.process_time()
        cells = planner.next_cells(Situation(cells, goals, nobody, NO_CELLS))
        times.append(time.process_time() - start)
    return times


def seconds_of_theirs(planner: Any, starts: list[Any]) -> float:
    """Return the processor time of the steps of pypibt, with its way of changing priorities."""
    cells = starts
    priorities = [
        table.get(cell) / table.table.size
        for table, cell in zip(planner.dist_tables, cells, strict=True)
    ]
    start = time.process_time()
    for _ in range(STEPS):
        cells = planner.step(cells, priorities)
        priorities = [
            priority + 1 if cell != goal else priority % 1
            for priority, cell, goal in zip(priorities, cells, planner.goals, strict=True)
        ]
    return time.process_time() - start


@pytest.mark.parametrize("robots", [400, 1_000])
def test_decisions_a_second(robots: int, measured, monkeypatch) -> None:
    monkeypatch.syspath_prepend(os.environ["PYPIBT"])
    pypibt = importlib.import_module("pypibt")
    layout = random_layout(64, 64, 0.1, 1)
    cells, goals = draw(layout, robots)
    is_open = np.zeros((64, 64), np.bool_)
    is_open.flat[layout.open_cells] = True
    starts, ends = ([divmod(cell, 64) for cell in each.tolist()] for each in (cells, goals))
    theirs = pypibt.PIBT(is_open, starts, ends)
    for table in theirs.dist_tables:
        for cell in layout.open_cells.tolist():
            table.get(divmod(cell, 64))
    ours = PIBT(Graph(layout))
    sum(seconds_of(ours, cells, goals))
    pairs = [
        (sum(seconds_of(ours, cells, goals)), seconds_of_theirs(theirs, starts))
        for _ in range(ROUNDS)
    ]
    rates = [robots * STEPS / min(column) for column in zip(*pairs, strict=True)]
    measured(
        f"decisions of PIBT a second of CPU time, {robots:,} robots",
        f"{rates[0]:,.0f}; pypibt {rates[1]:,.0f}; {rates[0] / rates[1]:.1f} times",
    )
    assert rates[0] >= 3 * rates[1]


def test_a_step_of_ten_thousand_robots(measured) -> None:
    layout = big_warehouse()
    cells, goals = draw(layout, 10_000)
    planner = PIBT(Graph(layout))
    start = time.process_time()
    planner.next_cells(Situation(cells, goals, np.zeros(10_000, np.bool_), NO_CELLS))
    first, times = time.process_time() - start, seconds_of(planner, cells, goals)
    measured(
        "a step of PIBT, 10,000 robots, 140 x 500 cells",
        f"{np.median(times):.3f} s of CPU time, at most {max(times):.3f} s; "
        f"distances of 10,000 goals {first:.0f} s, {planner.fields.matrix.nbytes / 1e9:.2f} GB",
    )
    assert max(times) < 0.1
