"""Which moves are open from every cell of a layout: the part of all its problems that stays."""

from __future__ import annotations

from functools import lru_cache

from warehouse_core.layout import DROPOFF, EMPTY, MOVE_DELTAS, PICKUP, Cell, Layout

Moves = tuple[tuple[str, Cell, float], ...]
"""Each move that no wall stops, the cell that it leads to, and its cost in steps: EXPAND."""


class Floor(dict[Cell, Moves]):
    """The moves from every cell of some walls, worked out when a cell is first asked for."""

    def __init__(self, walls: Layout) -> None:
        super().__init__()
        self._walls = walls

    def __missing__(self, cell: Cell) -> Moves:
        row, col = cell
        moves = self[cell] = tuple(
            (move, (row + down, col + right), 1.0)
            for move, (down, right) in MOVE_DELTAS.items()
            if self._walls.is_open((row + down, col + right))
        )
        return moves


def floor_of(layout: Layout) -> Floor:
    """Return the floor of a layout, the same one for all that have its walls."""
    return _floor(tuple(row.replace(PICKUP, EMPTY).replace(DROPOFF, EMPTY) for row in layout.rows))


@lru_cache(maxsize=8)
def _floor(walls: tuple[str, ...]) -> Floor:
    return Floor(Layout(walls))
