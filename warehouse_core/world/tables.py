"""What depends on nothing but the layout, worked out once for every cell of every layout.

A batch looks up in these tables what a single environment works out: what one row of a table holds
is then one ``take``, however many cells a window has. The cells of all layouts follow each other in
one long row; a cell has the number ``base + row * W + col``, with ``base`` where its layout begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import (
    CELL_CODES,
    CODE_OF_BYTE,
    MOVE_DELTAS,
    WALL,
)

MAX_TABLE_BYTES = 2**30
"""Of the windows of a batch; larger ones are refused before they are made."""


class LayoutSet:
    """The layouts of ``B`` rows, of which those that are alike are kept once.

    Attributes:
        kinds: the layouts that differ.
        kind: ``[B]`` intp, index into ``kinds`` for each row.
        base: ``[B]`` intp, the number of the first cell of its layout.
        width: ``[B]`` intp, columns of its layout.
    """

    def __init__(self, layouts: Sequence[Layout]) -> None:
        numbers: dict[Layout, int] = {}
        # Looked up by identity first, as a layout is hashed cell by cell.
        number_of = {id(layout): layout for layout in layouts}
        known = {key: numbers.setdefault(each, len(numbers)) for key, each in number_of.items()}
        self.kinds = tuple(numbers)
        self.kind = np.array([known[id(layout)] for layout in layouts], np.intp)
        self.base = self.of_rows(np.cumsum([0, *map(size_of, self.kinds)])[:-1])
        self.width = self.of_rows([layout.width for layout in self.kinds])

    @property
    def rows(self) -> list[Layout]:
        """The layout of each row."""
        return [self.kinds[kind] for kind in self.kind]

    def without_stations(self) -> LayoutSet:
        """Return the same rows with layouts that have no pickup and no dropoff."""
        bare = [kind.with_stations(None, None) for kind in self.kinds]
        return LayoutSet([bare[kind] for kind in self.kind])

    def of_rows(self, values: Sequence[int] | NDArray[Any]) -> NDArray[np.intp]:
        """Return for each row the value of its layout."""
        return np.asarray(values, np.intp)[self.kind]


def size_of(layout: Layout) -> int:
    """Return how many cells a layout has, walls included."""
    return layout.height * layout.width


def tiles_table(layouts: Sequence[Layout]) -> NDArray[np.uint8]:
    """Return the code of the tile of every cell, ``[N]``."""
    return np.concatenate([tile_codes(layout).ravel() for layout in layouts])


def places_table(layouts: Sequence[Layout]) -> NDArray[np.int32]:
    """Return row and column of every cell in its layout, ``[N, 2]``."""
    places = [
        np.indices((layout.height, layout.width), np.int32).reshape(2, -1).T for layout in layouts
    ]
    # Row and column side by side in memory: otherwise each look would copy the whole table first.
    return np.ascontiguousarray(np.concatenate(places))


def sides_table(layouts: Sequence[Layout]) -> NDArray[np.bool_]:
    """Return whether one can drive N, E, S and W from every cell, ``[N, 4]``."""
    return np.concatenate([_sides(layout) for layout in layouts])


def windows_table(layouts: Sequence[Layout], radius: int) -> NDArray[np.uint8]:
    """Return what is seen from every cell without the robot, ``[N, K * K]`` codes.

    Raises:
        LayoutError: the table would be larger than ``MAX_TABLE_BYTES``.
    """
    side = 2 * radius + 1
    needed = sum(map(size_of, layouts)) * side**2
    if needed > MAX_TABLE_BYTES:
        raise LayoutError(
            f"windows of {side} x {side} for {len(layouts)} layouts take {needed} bytes; "
            f"MAX_TABLE_BYTES = {MAX_TABLE_BYTES} are allowed"
        )
    return np.concatenate([_windows(layout, radius) for layout in layouts])


def _walled(layout: Layout, margin: int) -> NDArray[np.uint8]:
    """Return the codes of the tiles with a margin of walls around them."""
    return np.pad(tile_codes(layout), margin, constant_values=CELL_CODES[WALL])


def _sides(layout: Layout) -> NDArray[np.bool_]:
    is_open = _walled(layout, 1) != CELL_CODES[WALL]
    height, width = layout.height, layout.width
    return np.stack(
        [
            is_open[1 + down : 1 + down + height, 1 + right : 1 + right + width].ravel()
            for down, right in MOVE_DELTAS.values()
        ],
        axis=-1,
    )


def _windows(layout: Layout, radius: int) -> NDArray[np.uint8]:
    side = 2 * radius + 1
    views = np.lib.stride_tricks.sliding_window_view(_walled(layout, radius), (side, side))
    return views.reshape(size_of(layout), side**2)


def tile_codes(layout: Layout) -> NDArray[np.uint8]:
    """Return the codes of all tiles of a layout, ``[H, W]``, fresh."""
    codes = bytearray("".join(layout.rows).encode("ascii").translate(CODE_OF_BYTE))
    return np.frombuffer(codes, np.uint8).reshape(layout.height, layout.width)
