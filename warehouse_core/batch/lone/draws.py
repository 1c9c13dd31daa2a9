"""What each row of a batch draws for an episode, from a random stream of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_core.arguments import as_cell
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
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Integers, LayoutSet
from warehouse_core.world.tiles import Cell


class EpisodeDraws:
    """Draws stations and starts of ``B`` rows by ``task/starts.py``.

    If ``layouts`` has ``others``, each row draws its layout from them.
    """

    def __init__(
        self, layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None, drawn: Drawn
    ) -> None:
        self._drawn, self._layouts = drawn, layouts
        start, starts = _given_starts(len(layouts.kind), start_pos)
        self._start_of_kind = np.array([_start_in(kind, start) for kind in layouts.kinds])
        self._starts = layouts.of_rows(self._start_of_kind)
        for row, each in enumerate(starts):
            self._starts[row] = _start_in(layouts.rows[row], each, f"start_pos[{row}]")
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
        drawn = [others[int(self.stream(row).random() * len(others))] for row in rows.tolist()]
        self._layouts.change(rows, drawn)
        self._starts[rows] = self._start_of_kind[self._layouts.kind[rows]]
        return drawn

    def draw(self, rows: Integers) -> tuple[Integers | None, Integers]:
        """Return the stations and starts of the next episodes of some rows.

        Returns:
            ``[2, N]`` pickups and dropoffs, or ``None`` if they are not drawn, and ``[N]`` starts,
            all as cells within their layouts.
        """
        starts = self._starts[rows]
        if not any(self._drawn):
            return None, starts
        uniforms = np.array([self.stream(row).random(DRAWS) for row in rows.tolist()])
        uniforms, kinds = uniforms.reshape(-1, DRAWS), self._layouts.kind[rows]
        counts, first, stations = self._counts[kinds], self._first[kinds], None
        if self._drawn.stations:
            ranks = draw_ranks(uniforms, counts).T
            stations, ranks = self._cells.take(first + ranks[:2]), ranks[2]
        else:
            ranks = draw_start_ranks(uniforms, counts)
        if self._drawn.start:
            drawn = self._cells.take(first + ranks, mode="clip")
            starts = np.where(ranks == NO_RANK, starts, drawn)
        return stations, starts


def _given_starts(rows: int, start_pos: Any) -> tuple[Any, Sequence[Any]]:
    """Return the start that all rows have in common, or ``None``, and those given for each row."""
    if start_pos is None:
        return None, ()
    if not isinstance(start_pos, (list, tuple, np.ndarray)):
        raise TypeError(f"start_pos is {brief(start_pos)}; it must be a cell, or one for each row")
    try:
        given = np.asarray(start_pos)
    except ValueError:  # rows of different lengths
        given = np.asarray(start_pos, object)
    if given.shape == (2,):
        return given.tolist(), ()
    if given.shape == (rows, 2):
        return None, given.tolist()
    raise ValueError(
        f"start_pos has the shape {given.shape}; allowed: one cell (row, column) for all "
        f"rows, or one for each, shape ({rows}, 2)"
    )


def _start_in(layout: Layout, start_pos: Any, name: str = "start_pos") -> int:
    """Return the number of a start in a layout; ``None`` is the usual one."""
    if start_pos is None:
        return layout.number(layout.usual_start())
    cell = as_cell(name, start_pos)
    check_open(layout, cell, name)
    return layout.number(cell)
