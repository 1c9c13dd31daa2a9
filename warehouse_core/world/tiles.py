"""Cells and tiles, with the characters and codes of tiles.

A *cell* is ``(row, col)``, both counted from 0. Row 0 is the top row.
"""

from __future__ import annotations

import re

Cell = tuple[int, int]
"""Row and column, counted from 0 at the top left."""

WALL, EMPTY, PICKUP, DROPOFF, CHARGER = "#", ".", "P", "D", "C"

TILES = {
    WALL: "wall", EMPTY: "empty", PICKUP: "pickup", DROPOFF: "dropoff", CHARGER: "charger",
}  # fmt: skip

ALLOWED_TILES = ", ".join(f"{tile} ({name})" for tile, name in TILES.items())

NO_STATIONS = str.maketrans(dict.fromkeys((PICKUP, DROPOFF, CHARGER), EMPTY))
"""Table for ``str.translate`` that replaces stations and chargers with floor."""

MOVE_DELTAS: dict[str, Cell] = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def moved(cell: Cell, delta: Cell) -> Cell:
    """Return the cell that is ``delta`` rows and columns away from ``cell``."""
    return cell[0] + delta[0], cell[1] + delta[1]


def manhattan_distance(a: Cell, b: Cell) -> int:
    """Return ``|row_a - row_b| + |col_a - col_b|``, the moves between two cells without walls."""
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def runs_of(tile: str, row: str) -> list[tuple[int, int]]:
    """Return the columns ``(first, end)`` of each run of ``tile`` in a row, excluding ``end``."""
    return [run.span() for run in re.finditer(re.escape(tile) + "+", row)]


ROBOT_EMPTY, ROBOT_LOADED = "R", "r"

OTHER_EMPTY, OTHER_LOADED, PERSON = "O", "o", "H"
"""Characters of other robots and of people in the view of a robot."""

CELL_CODES = {
    character: code
    for code, character in enumerate(
        (
            EMPTY, WALL, PICKUP, DROPOFF, ROBOT_EMPTY, ROBOT_LOADED,
            CHARGER, OTHER_EMPTY, OTHER_LOADED, PERSON,
        )
    )
}  # fmt: skip
"""Code of each character in the array of a view; other robots and people have the largest."""

CODE_OF_BYTE = bytes(CELL_CODES.get(chr(byte), 255) for byte in range(256))
"""Table of the same codes for ``bytes.translate``."""
