"""Small problems of the League of Robot Runners."""

from collections.abc import Sequence
from typing import Any

from warehouse_core import Layout
from warehouse_core.world.robot_runners import League


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
