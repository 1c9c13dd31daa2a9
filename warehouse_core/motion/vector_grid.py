"""The grid backend for a batch: one table lookup moves every robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warehouse_core.motion.vector import BatchOutcome, Flags, Integers
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import LayoutSet, sides_table

_ACTIONS = len(DISPLACEMENTS)


class GridBatch:
    """Moves one robot in each of ``B`` layouts by whole cells; see ``BatchMotion``.

    Args:
        layouts: the ``B`` layouts.
        seconds: duration of every action.
        moving_joules: cost of a move, blocked or not.
        waiting_joules: cost of any other action.
    """

    def __init__(
        self,
        layouts: Sequence[Layout],
        *,
        seconds: float,
        moving_joules: float,
        waiting_joules: float,
    ) -> None:
        self._closed = False
        rows = LayoutSet(layouts)
        self._cells = np.zeros(len(rows.kind), np.int32)
        self._base = rows.base * _ACTIONS
        self._next = np.concatenate([_next_cells(layout) for layout in rows.kinds])
        self._seconds = np.full(len(rows.kind), seconds)
        is_move = np.arange(_ACTIONS) < WAIT
        self._joules = np.where(is_move, moving_joules, waiting_joules)

    def place(self, rows: Integers, cells: Integers) -> None:
        """Put some of the robots in their cells; see ``BatchMotion.place``."""
        self._cells[rows] = cells

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Move every robot by one action; see ``BatchMotion.advance``."""
        if self._closed:
            raise RuntimeError("advance() after close()")
        before = self._cells
        self._cells = self._next.take(self._base + before * _ACTIONS + actions)
        blocked = (self._cells == before) & (actions < WAIT)
        joules = self._joules.take(actions)
        return BatchOutcome(self._cells.astype(np.intp), blocked, self._seconds.copy(), joules)

    def close(self) -> None:
        """Make ``advance`` raise from now on; see ``BatchMotion.close``."""
        self._closed = True


def _next_cells(layout: Layout) -> Integers:
    """Return the cell after each action in each cell, ``[N * actions]``."""
    sides = sides_table([layout])
    steps = np.array([row * layout.width + col for row, col in DISPLACEMENTS])
    cells = np.repeat(np.arange(len(sides))[:, None], _ACTIONS, axis=1)
    cells[:, :WAIT] += sides * steps[:WAIT]
    return cells.ravel().astype(np.int32)  # int32 is faster to read than intp
