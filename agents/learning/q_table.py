"""Files of Q-learning tables: two arrays, the states and the values of their actions."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from agents.learning.q_learning import QAgent, QTable
from warehouse_core import RecordError
from warehouse_core.files.npz import Schema, read_arrays, write_arrays
from warehouse_core.world.actions import ACTIONS

SCHEMA: Schema = {"states": ("<i4", 2), "values": ("<f8", 2)}
"""A state is two cells and whether the robot holds the item: five numbers."""


def save_table(table: QTable, path: str | Path) -> None:
    """Write a table to one ``.npz`` file, whole or not at all.

    Raises:
        RecordError: it is larger than ``npz.MAX_BYTES``.
        OSError: the file cannot be written.
    """
    states = [(*robot, *goal, loaded) for robot, goal, loaded in table]
    arrays = {
        "states": np.array(states, np.int32).reshape(-1, 5),
        "values": np.array(list(table.values())).reshape(-1, len(ACTIONS)),
    }
    write_arrays(path, arrays, SCHEMA)


def load_table(path: str | Path) -> QTable:
    """Read a table that ``save_table`` wrote.

    Raises:
        RecordError: the file is damaged or has other contents; the message says which.
        OSError: the file cannot be read.
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
    for (row, col, goal_row, goal_col, loaded), known in zip(
        states.tolist(), values.tolist(), strict=True
    ):
        table[(row, col), (goal_row, goal_col), bool(loaded)] = known
    return table


def load_agent(path: Path, seed: int | None = None) -> QAgent:
    """Return an agent with a table from a file; raises what ``load_table`` raises."""
    return QAgent(load_table(path), seed)
