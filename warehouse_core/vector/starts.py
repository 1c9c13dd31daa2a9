"""The starts of episodes in a batch, drawn from a random stream for each row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import as_cell
from warehouse_core.motion.vector import Integers
from warehouse_core.task.starts import DRAWS, NO_RANK, check_room, draw_ranks
from warehouse_core.vector.floor import NO_CELL
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import Cell


class Starts(NamedTuple):
    """Cells, ``[N]`` each, numbered within their layouts."""

    pickups: Integers
    dropoffs: Integers
    robots: Integers


class VectorStarts:
    """Draws the starts of ``B`` rows by ``draw_ranks``, each from its own stream.

    Args:
        layouts: of the rows.
        start_pos: see ``BatchEnv``.
        randomize: draw the starts instead of using those of the layouts.

    Raises:
        LayoutError: a start that is not open, or no room for pickup and dropoff.
    """

    def __init__(
        self, layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None, *, randomize: bool
    ) -> None:
        self._randomize = randomize
        self._layouts = layouts
        self._fixed = _fixed_starts(layouts, start_pos)
        self._counts = layouts.of_rows([len(layout.open_cells) for layout in layouts.kinds])
        self._open = np.concatenate([layout.open_cells for layout in layouts.kinds])
        first = np.cumsum([0, *(len(layout.open_cells) for layout in layouts.kinds)])[:-1]
        self._first = layouts.of_rows(first)
        self._streams: list[np.random.Generator] = []
        if randomize:
            for layout in layouts.kinds:
                check_room(layout)

    def seed(self, rows: Integers, seeds: Sequence[int | None]) -> None:
        """Restart the streams of rows with a seed; the first call starts all of them."""
        if not self._randomize:
            return
        if not self._streams:
            self._streams = [np.random.default_rng(seed) for seed in seeds]
            return
        for row, seed in zip(rows.tolist(), seeds, strict=True):
            if seed is not None:
                self._streams[row] = np.random.default_rng(seed)

    def draw(self, rows: Integers) -> Starts:
        """Return the starts of the next episodes of some rows."""
        fixed = Starts(*(cells[rows] for cells in self._fixed))
        if not self._randomize:
            return fixed
        uniforms = np.array([self._streams[row].random(DRAWS) for row in rows.tolist()])
        ranks = draw_ranks(uniforms.reshape(-1, DRAWS), self._counts[rows])
        pickups, dropoffs, robots = self._open.take(self._first[rows] + ranks.T, mode="clip")
        return Starts(pickups, dropoffs, np.where(ranks[:, 2] == NO_RANK, fixed.robots, robots))


def _fixed_starts(layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None) -> Starts:
    """Return the stations of the layouts and the starts that are not drawn."""

    def cells(first: Callable[[Layout], Cell | None]) -> NDArray[np.intp]:
        return layouts.of_rows([_number(first(kind), kind.width) for kind in layouts.kinds])

    return Starts(
        cells(lambda layout: layout.pickups[0] if layout.pickups else None),
        cells(lambda layout: layout.dropoffs[0] if layout.dropoffs else None),
        cells(Layout.usual_start) if start_pos is None else _given_starts(layouts, start_pos),
    )


def _number(cell: Cell | None, width: int) -> int:
    return NO_CELL if cell is None else cell[0] * width + cell[1]


def _given_starts(layouts: LayoutSet, start_pos: Cell | Sequence[Cell]) -> NDArray[np.intp]:
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
    starts: NDArray[np.intp] = cells[:, 0] * layouts.width + cells[:, 1]
    return starts
