"""Lookup tables of a batch: everything about a cell that depends only on its layout.

``N`` is the number of cells in all layouts together. The number of a cell is
``base + row * W + col``, where ``base`` is the number of the first cell of its layout. So a batch
reads the values of all its rows with a single ``take``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import CELL_CODES, CODE_OF_BYTE, MOVE_DELTAS, WALL

Integers = NDArray[np.integer]
Flags = NDArray[np.bool_]
Rows = Integers | slice
"""Rows of a batch: an array of indices, or a slice."""

MAX_TABLE_BYTES = 2**30
"""Limit on the windows of a batch, checked before they are allocated."""


class LayoutSet:
    """The layouts of ``B`` rows; equal layouts are stored only once.

    Rows can change to ``others``, which are stored in advance, or to any other layout. With
    ``bare``, the pickups and dropoffs of all layouts are removed.

    Attributes:
        kinds: different layouts.
        kind: ``[B]`` intp, index into ``kinds`` for each row.
        base: ``[B]`` intp, number of the first cell of each row's layout.
        width: ``[B]`` intp, columns of each row's layout.
    """

    def __init__(
        self, layouts: Sequence[Layout], others: Sequence[Layout] = (), *, bare: bool = False
    ) -> None:
        self._numbers: dict[Layout, int] = {}
        self.kinds: tuple[Layout, ...] = ()
        if bare:
            layouts, others = _without_stations(layouts), _without_stations(others)
        self.others = tuple(others)
        self.kind = self._numbers_of([*layouts, *others])[: len(layouts)]
        self.base, self.width = self.of_rows(self._bases), self.of_rows(self._widths)

    @property
    def rows(self) -> list[Layout]:
        """The layout of each row."""
        return [self.kinds[kind] for kind in self.kind]

    def change(self, rows: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of some rows; ``kind``, ``base`` and ``width`` change in place."""
        kinds = self._numbers_of(layouts)
        self.kind[rows] = kinds
        self.base[rows], self.width[rows] = self._bases[kinds], self._widths[kinds]

    def of_rows(self, values: ArrayLike) -> NDArray[np.intp]:
        """Return the value of each row's layout, given a value for each of ``kinds``."""
        return np.asarray(values, np.intp)[self.kind]

    def _numbers_of(self, layouts: Sequence[Layout]) -> NDArray[np.intp]:
        """Return the indices of layouts in ``kinds``, after adding new layouts to it."""
        numbers = self._numbers
        # Hashing takes time proportional to the cells, so identical objects are hashed once.
        by_id = {id(layout): layout for layout in layouts}
        known = {key: numbers.setdefault(each, len(numbers)) for key, each in by_id.items()}
        if len(self.kinds) < len(numbers):
            self.kinds = tuple(numbers)
            self._bases = np.cumsum([0, *map(size_of, self.kinds)])[:-1]
            self._widths = np.array([layout.width for layout in self.kinds])
        return np.array([known[id(layout)] for layout in layouts], np.intp)


def _without_stations(layouts: Sequence[Layout]) -> list[Layout]:
    """Return the layouts without pickups and dropoffs; identical objects stay identical."""
    bare = {id(layout): layout for layout in layouts}
    bare = {key: layout.with_stations(None, None) for key, layout in bare.items()}
    return [bare[id(layout)] for layout in layouts]


def size_of(layout: Layout) -> int:
    """Return the number of cells of a layout, including walls."""
    return layout.height * layout.width


def tiles_table(layouts: Sequence[Layout]) -> NDArray[np.uint8]:
    """Return the tile code of every cell, ``[N]``."""
    return np.concatenate([tile_codes(layout).ravel() for layout in layouts])


def places_table(layouts: Sequence[Layout]) -> NDArray[np.int32]:
    """Return the row and column of every cell in its layout, ``[N, 2]``."""
    places = [
        np.indices((layout.height, layout.width), np.int32).reshape(2, -1).T for layout in layouts
    ]
    # Rows and columns alternate in memory; otherwise each take would copy the whole table.
    return np.ascontiguousarray(np.concatenate(places))


def sides_table(layouts: Sequence[Layout]) -> NDArray[np.bool_]:
    """Return whether the neighbours of every cell to the N, E, S and W are open, ``[N, 4]``."""
    return np.concatenate([_sides(layout) for layout in layouts])


def windows_bytes(layouts: Sequence[Layout], radius: int) -> int:
    """Return the size of ``windows_table`` in bytes."""
    return sum(map(size_of, layouts)) * (2 * radius + 1) ** 2


def windows_table(layouts: Sequence[Layout], radius: int) -> NDArray[np.uint8]:
    """Return the window around every cell, without the robot, as codes ``[N, K * K]``.

    Raises:
        LayoutError: the table would be larger than ``MAX_TABLE_BYTES``.
    """
    side, needed = 2 * radius + 1, windows_bytes(layouts, radius)
    if needed > MAX_TABLE_BYTES:
        raise LayoutError(
            f"windows of {side} x {side} for {len(layouts)} layouts take {needed} bytes; "
            f"MAX_TABLE_BYTES = {MAX_TABLE_BYTES} are allowed"
        )
    return np.concatenate([_windows(layout, radius).reshape(-1, side**2) for layout in layouts])


def _sides(layout: Layout) -> NDArray[np.bool_]:
    windows = _windows(layout, radius=1)
    sides = [windows[..., 1 + down, 1 + right].ravel() for down, right in MOVE_DELTAS.values()]
    return np.stack([side != CELL_CODES[WALL] for side in sides], axis=-1)


def _windows(layout: Layout, radius: int) -> NDArray[np.uint8]:
    """Return a view of the window around every cell, ``[H, W, K, K]``."""
    walled = np.pad(tile_codes(layout), radius, constant_values=CELL_CODES[WALL])
    return np.lib.stride_tricks.sliding_window_view(walled, (2 * radius + 1,) * 2)


def tile_codes(layout: Layout) -> NDArray[np.uint8]:
    """Return the codes of all tiles of a layout as a new ``[H, W]`` array."""
    codes = bytearray("".join(layout.rows).encode("ascii").translate(CODE_OF_BYTE))
    return np.frombuffer(codes, np.uint8).reshape(layout.height, layout.width)
