"""Goals a step on floors that are nearly full: no costs of moves, lanes, and directed costs."""

import numpy as np
import pytest

from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.lifelong import run_lifelong
from agents.mapf.traffic import directed_costs
from warehouse_core import random_layout

STEPS, SEEDS, WRONG_WAY = 1000, range(2), 4.0

LEAST = 1.08
"""How many times as many goals are reached with directed costs as with lanes, at least."""


@pytest.mark.parametrize("size", [14, 32])
def test_goals_a_step_of_circulations(size: int, measured) -> None:
    layout = random_layout(size, size, 0.2, seed=1)
    robots = int(0.97 * len(layout.open_cells))
    every = None, lane_costs(layout, WRONG_WAY), directed_costs(layout, robots)
    found = [
        np.mean([
            run_lifelong(graph, Circulation(graph), robots, STEPS, seed, has_headings=True)
            .throughput
            for seed in SEEDS
        ])
        for graph in (Graph(layout, costs) for costs in every)
    ]  # fmt: skip
    plain, lanes, directed = found
    measured(
        f"goals a step, {robots} robots with headings on {len(layout.open_cells)} cells",
        f"circulations {plain:.2f}; on lanes {lanes:.2f}; with directed costs {directed:.2f}",
    )
    assert size < 32 or directed > LEAST * lanes
