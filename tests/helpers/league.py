"""Small problems of the League of Robot Runners."""

import json
from collections.abc import Sequence
from pathlib import Path
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


def write_hall(tasks: str = "2\n4,0\n9,5\n", **fields: Any) -> str:
    """Write a problem with two robots, one behind the other, and return its name.

    Args:
        tasks: text of its tasks, each of which leads to one end of the hall, and back.
        fields: further fields.
    """
    Path("hall.map").write_text("type octile\nheight 2\nwidth 5\nmap\n.....\n.....\n")
    Path("hall.agents").write_text("2\n0\n5\n")
    Path("hall.tasks").write_text(tasks)
    files = {f"{name}File": f"hall.{name}s" for name in ("agent", "task")}
    problem = {"mapFile": "hall.map", **files, "teamSize": 2}
    Path("hall.json").write_text(json.dumps(problem | fields))
    return "hall.json"
