"""A warehouse of the shape that papers on lifelong runs use: 33 x 46 cells, shelves in 24 rows.

The measures are those of Li et al. (2021), Lifelong multi-agent path finding in large-scale
warehouses, AAAI: robots start in blocks of parking places at both sides, goals lie along shelves.
"""

import numpy as np

from warehouse_core import Layout

SHELF_ROWS, SHELF_COLUMNS, SHELF = 8, 3, 10
PARKING = ".SS.SS."


def kiva_warehouse() -> tuple[Layout, np.ndarray, np.ndarray]:
    """Return the layout, the cells of the starts, 192, and those of the goals, 480."""
    beside, shelves = (".".join([each * SHELF] * SHELF_COLUMNS) for each in "G#")
    block = [f"{PARKING}{row}{PARKING}" for row in (beside, shelves, beside)]
    aisle = "." * len(block[0])
    text = "".join([aisle, *[*block, aisle] * SHELF_ROWS])
    rows = text.replace("S", ".").replace("G", ".")
    width, marks = len(aisle), np.array(list(text))
    layout = Layout([rows[at : at + width] for at in range(0, len(rows), width)])
    return layout, np.flatnonzero(marks == "S"), np.flatnonzero(marks == "G")
