"""Files of Q-learning tables, with the states, the values of their actions, and the walls."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from agents.errors import AgentError
from agents.learning.q_learning import QAgent, QTable
from warehouse_core import DEFAULT_LAYOUT, Layout, RecordError
from warehouse_core.files.npz import Schema, read_arrays, write_arrays
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import WALL

SCHEMA: Schema = {"states": ("<i4", 2), "values": ("<f8", 2), "walls": ("|b1", 2)}
"""Arrays of a file. A state is five numbers: two cells and whether the robot holds the item."""


def save_table(table: QTable, layout: Layout, path: str | Path) -> None:
    """Write a table and the walls of its layout to a ``.npz`` file, completely or not at all.

    Raises:
        RecordError: the table is larger than ``npz.MAX_BYTES``.
        OSError: the file cannot be written.

    Example:
        >>> from agents.learning import QTable, save_table
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> save_table(QTable(), DEFAULT_LAYOUT, "table.npz")
    """
    states = [(*robot, *goal, loaded) for robot, goal, loaded in table]
    arrays = {
        "states": np.array(states, np.int32).reshape(-1, 5),
        "values": np.array(list(table.values())).reshape(-1, len(ACTIONS)),
        "walls": _walls(layout),
    }
    write_arrays(path, arrays, SCHEMA)


def load_table(path: str | Path) -> tuple[QTable, NDArray[np.bool_]]:
    """Read a table that ``save_table`` wrote, and the walls ``[H, W]`` of its layout.

    Raises:
        RecordError: the file is damaged or has other contents; the message says which.
        OSError: the file cannot be read.

    Example:
        >>> from agents.learning import QTable, load_table, save_table
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> save_table(QTable(), DEFAULT_LAYOUT, "table.npz")
        >>> table, walls = load_table("table.npz")
        >>> walls.shape
        (7, 12)
    """
    arrays = read_arrays(path, SCHEMA)
    states, values = arrays["states"], arrays["values"]
    count = len(states)
    if states.shape != (count, 5) or values.shape != (count, len(ACTIONS)):
        raise RecordError(
            f"{path}: states {states.shape} and values {values.shape}; "
            f"they must be (N, 5) and (N, {len(ACTIONS)})"
        )
    if not np.isfinite(values).all():
        raise RecordError(f"{path}: it has values that are not finite")
    table = QTable()
    rows = zip(states.tolist(), values.tolist(), strict=True)
    for (row, col, goal_row, goal_col, loaded), known in rows:
        table[(row, col), (goal_row, goal_col), bool(loaded)] = known
    return table, arrays["walls"]


def load_agent(path: Path, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT) -> QAgent:
    """Return an agent with a table from a file, for use in a layout.

    Raises:
        AgentError: the table is for a layout with other walls.
        RecordError: see ``load_table``.
        OSError: the file cannot be read.

    Example:
        >>> from pathlib import Path
        >>> from agents.learning import QTable, load_agent, save_table
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> save_table(QTable(), DEFAULT_LAYOUT, "table.npz")
        >>> agent = load_agent(Path("table.npz"), seed=1)
    """
    table, walls = load_table(path)
    if not np.array_equal(walls, _walls(layout)):
        height, width = walls.shape
        raise AgentError(
            f"{path}: the table was learned on a layout of {height} x {width} cells; this one has "
            f"{layout.height} x {layout.width} cells and other walls; train on it with 'warehouse "
            "train q --layout'"
        )
    return QAgent(table, seed)


def _walls(layout: Layout) -> NDArray[np.bool_]:
    return np.array([[tile == WALL for tile in row] for row in layout.rows])
