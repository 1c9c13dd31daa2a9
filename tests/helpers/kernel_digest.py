"""Prints a digest of plans by all kernels, which plain Python and Numba must have in common."""

import hashlib
from collections.abc import Iterator
from math import inf

import numpy as np

from agents.mapf.anytime import solve_anytime
from agents.mapf.graph import Graph
from agents.mapf.kernels.buffers import IS_COMPILED
from agents.mapf.lacam import LaCAM
from agents.mapf.lanes import lane_costs
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner
from agents.mapf.windows import WindowedPlanner
from helpers.mapf_problems import random_problem, situation
from warehouse_core import random_layout


def lifelong(planner: Planner, graph: Graph, robots: int, seed: int) -> Iterator[np.ndarray]:
    """Yield the cells of robots some of which stay, among cells some of which are closed."""
    stream = np.random.default_rng(seed)
    cells, goals = (stream.permutation(graph.layout.open_cells)[:robots] for _ in range(2))
    for _ in range(40):
        closed = stream.choice(graph.layout.open_cells, 3)
        stays = stream.random(robots) < 0.05
        given = situation(cells, goals, np.flatnonzero(stays), closed)
        cells = planner.next_cells(given)
        goals = np.where(
            cells == goals, stream.permutation(graph.layout.open_cells)[:robots], goals
        )
        yield cells


def results() -> Iterator[np.ndarray]:
    """Yield cells that the kernels have led robots to."""
    for seed in range(3):
        layout = random_layout(14, 16, 0.2, seed)
        for costs in (None, lane_costs(layout, 2.5)):
            for turn_cost in (0.0, 1.3):
                graph = Graph(layout, costs)
                yield from lifelong(PIBT(graph, seed, turn_cost), graph, 40, seed)
                windows = WindowedPlanner(graph, 8, 6, inf, seed, turn_cost)
                yield from lifelong(windows, graph, 40, seed)
        problem = random_problem(layout, 60, seed)
        yield solve_anytime(problem, 3_600.0, seed, trials=30).cells
        small = LaCAM(random_problem(random_layout(6, 6, 0.2, seed), 5, seed), seed)
        small.search(inf, rounds=3_000)
        plan = small.plan()
        assert plan is not None
        yield plan.cells


if __name__ == "__main__":
    digest = hashlib.sha256()
    for cells in results():
        digest.update(np.asarray(cells, np.int64).tobytes())
    print("compiled" if IS_COMPILED else "plain", digest.hexdigest())
