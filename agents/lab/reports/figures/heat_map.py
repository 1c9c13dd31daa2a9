"""Heat maps of the cells where robots get stuck, one for each failure mode.

``H`` is the height of the layout and ``W`` its width, in cells.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from agents.errors import StoreError
from agents.lab.experiments.store import Store
from agents.lab.reports.figures.panels import WIDE, Sheet
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import MODES
from warehouse_core.viz.axes.heat_map import CellCounts, heat_map

STUCK = f"""
SELECT mode, row, col, count(*) FROM episodes
WHERE case_id IN (SELECT value FROM json_each(?)) AND mode != '{DELIVERED}'
GROUP BY mode, row, col
"""


MAX_WIDTH = 7.4
"""Inches between the margins of A4 paper, which does not make the small text of a map smaller."""


def stuck_cells(
    store: Store, rows: Sequence[str], case_ids: Sequence[int]
) -> dict[str, CellCounts]:
    """Count the cells ``[H, W]`` where episodes ended or were stuck, by mode in their usual order.

    An episode that was stuck where the layout of the cases has no cell is a ``StoreError``.
    """
    stuck: dict[str, CellCounts] = {}
    for mode, row, col, count in store.query(STUCK, json.dumps(list(case_ids))):
        counts = stuck.setdefault(mode, np.zeros((len(rows), len(rows[0])), dtype=np.int64))
        if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
            raise StoreError(f"{store.path}: row {row}, column {col} is off the layout")
        counts[row, col] = count
    return {mode: stuck[mode] for mode in MODES if mode in stuck}


def stuck_heat_map(
    rows: Sequence[str],
    stuck: Mapping[str, CellCounts],
    episodes: int,
    sheet: Sheet = WIDE,
    *,
    with_stations: bool = False,
) -> Figure:
    """Return the heat maps of a layout, one panel for each mode that ``stuck_cells`` gives.

    Shares are of all episodes, deliveries included.
    """
    titled = {
        f"{mode}: {cells.sum():,} ({cells.sum() / episodes:.1%})": cells
        for mode, cells in stuck.items()
    }
    width = min(sheet.width, MAX_WIDTH)
    return heat_map(rows, titled, width=width, with_stations=with_stations)
