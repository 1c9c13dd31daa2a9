"""The walls of a layout as few rectangles, in a fixed order.

With one box for each cell there would be seams, which stop a body that slides along a wall. The
order of the boxes affects results. So wall cells are merged greedily, first along rows and then
downwards.
"""

from __future__ import annotations

from warehouse_core import Layout
from warehouse_core.world.tiles import WALL, runs_of

CellBox = tuple[int, int, int, int]
"""Left, top, right and bottom edge, in cells."""


def wall_boxes(layout: Layout) -> list[CellBox]:
    """Return boxes that cover the walls exactly, after four boxes around the edge of the grid."""
    height, width = layout.height, layout.width
    boxes = [
        (-1, -1, width + 1, 0),
        (-1, height, width + 1, height + 1),
        (-1, 0, 0, height),
        (width, 0, width + 1, height),
    ]
    growing: dict[tuple[int, int], int] = {}
    for row, line in enumerate([*layout.rows, ""]):
        runs = runs_of(WALL, line)
        for run in [run for run in growing if run not in runs]:
            boxes.append((run[0], growing.pop(run), run[1], row))
        for run in runs:
            growing.setdefault(run, row)
    return boxes
