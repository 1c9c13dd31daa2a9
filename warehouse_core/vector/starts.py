"""The starts of episodes in a batch, drawn from a random stream for each row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import as_cell
from warehouse_core.motion.vector import Integers
from warehouse_core.task.starts import (
    DRAWS,
    NO_RANK,
    Drawn,
    check_room,
    draw_ranks,
    draw_start_ranks,
    empty_cells,
    station_cells,
)
from warehouse_core.vector.floor import NO_CELL
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import Cell


class VectorStarts:
    """Draws the starts of ``B`` rows by ``task/starts.py``, each from its own stream.

    ``start_pos`` is that of ``BatchEnv``, ``drawn`` what its ``randomize`` stands for. If there are
    ``others`` among the layouts, each row draws its layout from them too.

    Raises:
        LayoutError: a start that is not open, or no room for pickup and dropoff.
    """

    def __init__(
        self, layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None, drawn: Drawn
    ) -> None:
        self._drawn, self._layouts = drawn, layouts
        self._fixed = _fixed_cells(layouts, start_pos)
        if layouts.others:
            self._fixed_of_others = _fixed_cells(LayoutSet(layouts.others), start_pos)
        # A station is drawn from all cells without a charger, a start from those it leaves.
        cells = [station_cells(k) if drawn.stations else empty_cells(k) for k in layouts.kinds]
        counts = [len(each) for each in cells]
        self._counts = np.array(counts)
        self._cells = np.concatenate(cells)
        self._first = np.cumsum([0, *counts])[:-1]
        self._seeds: dict[int, int] = {}
        self._streams: dict[int, np.random.Generator] = {}
        if drawn.stations:
            for layout in layouts.kinds:
                check_room(layout)

    def seed(self, rows: Integers, seeds: Sequence[int | None]) -> None:
        """Restart the streams of those rows that have a seed."""
        for row, seed in zip(rows.tolist(), seeds, strict=True):
            if seed is not None:
                self._seeds[row] = seed
                self._streams.pop(row, None)

    def seed_of(self, row: int) -> int:
        """Return the last seed of a row; a row that had none gets a random one."""
        if row not in self._seeds:
            entropy = np.random.SeedSequence().entropy
            assert isinstance(entropy, int), "it is drawn from the operating system"
            self._seeds[row] = entropy
        return self._seeds[row]

    def stream(self, row: int) -> np.random.Generator:
        """Return the random stream of a row, which is made when it is needed first."""
        if row not in self._streams:
            self._streams[row] = np.random.default_rng(self.seed_of(row))
        return self._streams[row]

    def draw_layouts(self, rows: Integers) -> list[Layout]:
        """Give some rows layouts drawn from the ``others``, and return these."""
        others = self._layouts.others
        places = [int(self.stream(row).random() * len(others)) for row in rows.tolist()]
        drawn = [others[place] for place in places]
        self._layouts.change(rows, drawn)
        self._fixed[:, rows] = self._fixed_of_others[:, places]
        return drawn

    def draw(self, rows: Integers) -> Integers:
        """Return the starts of the next episodes of some rows.

        Returns:
            ``[3, N]`` the pickups, the dropoffs and the robots, as cells within their layouts.
        """
        fixed = self._fixed[:, rows]
        if not any(self._drawn):
            return fixed
        uniforms = np.array([self.stream(row).random(DRAWS) for row in rows.tolist()])
        uniforms, kinds = uniforms.reshape(-1, DRAWS), self._layouts.kind[rows]
        counts = self._counts[kinds]
        ranks = np.full((3, len(rows)), NO_RANK)
        if self._drawn.stations:
            ranks[:] = draw_ranks(uniforms, counts).T
        else:
            ranks[2] = draw_start_ranks(uniforms, counts)
        if not self._drawn.start:
            ranks[2] = NO_RANK
        drawn = self._cells.take(self._first[kinds] + ranks, mode="clip")
        return np.where(ranks == NO_RANK, fixed, drawn)


def _fixed_cells(layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None) -> NDArray[np.intp]:
    """Return the first pickup, the first dropoff and the start of each row, ``[3, B]`` cells."""
    robots = _fixed_starts(layouts, start_pos)
    return np.stack([*first_stations(layouts).T, robots[:, 0] * layouts.width + robots[:, 1]])


def first_stations(layouts: LayoutSet) -> NDArray[np.intp]:
    """Return the first pickup and dropoff of each row, ``[B, 2]`` cells or ``NO_CELL``."""
    return layouts.of_rows(
        [
            [
                next((row * kind.width + col for row, col in cells), NO_CELL)
                for cells in (kind.pickups, kind.dropoffs)
            ]
            for kind in layouts.kinds
        ]
    )


def _fixed_starts(layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None) -> NDArray[np.intp]:
    """Return row and column of the starts that are not drawn, ``[B, 2]``."""
    if start_pos is None:
        return layouts.of_rows([kind.usual_start() for kind in layouts.kinds])
    rows = len(layouts.kind)
    try:
        given = np.asarray(start_pos)
    except ValueError:  # rows of different lengths
        given = np.asarray(start_pos, object)
    if given.shape not in ((2,), (rows, 2)):
        raise ValueError(
            f"start_pos has the shape {given.shape}; allowed: one cell (row, column) for all "
            f"rows, or one for each, shape ({rows}, 2)"
        )
    cells = np.broadcast_to(given, (rows, 2))
    for row, (cell, kind) in enumerate(zip(cells.tolist(), layouts.kind, strict=True)):
        name = "start_pos" if given.ndim == 1 else f"start_pos[{row}]"
        check_open(layouts.kinds[kind], as_cell(name, cell), name)
    return cells.astype(np.intp)
