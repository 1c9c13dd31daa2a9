"""Small problems of the League of Robot Runners."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_core import Layout, random_layout
from warehouse_core.world.robot_runners import Delays, League

OPEN = random_layout(10, 10, 0.15, seed=2).with_tiles([], [], [])
DELAYS = Delays(1, 2, 6, "bernoulli", 0.02, "uniform", 0.5, 0.2)


def league_of(
    rows: Sequence[str], starts: Sequence[int], tasks: Sequence[Sequence[int]], **fields: Any
) -> League:
    """Return a problem of 2024, or of another year; starts and tasks are numbers of cells."""
    layout = Layout(rows)
    given = {
        "revealed": len(starts), "strategy": "", "year": 2024, "ticks": 1, "robot_size": 1.0,
        "delays": None,
    }  # fmt: skip
    cells = [tuple(map(layout.cell, task)) for task in tasks]
    return League(layout, [*map(layout.cell, starts)], cells, **given | fields)


def league_crowd() -> League:
    """Return a problem of 2026 with 16 robots among walls, and delays."""
    cells = np.random.default_rng(3).permutation(OPEN.open_cells).tolist()
    tasks = [cells[start : start + 2] for start in range(len(cells) - 2)]
    fields = {"revealed": 24, "year": 2026, "ticks": 3, "delays": DELAYS}
    return league_of(OPEN.rows, cells[:16], tasks, **fields)
