"""Sets of cells as whole numbers with one bit for each cell.

One bit operation moves a robot from all cells that it may be in.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from agents.mapf.graph import Graph


class CellSets:
    """The sets of cells of a floor.

    A column of wall is added on the right, so that no move leads from one row into the next.

    Attributes:
        bits: set with only this cell, for each cell number.
        open: set of all open cells.
        row: distance between the bits of a cell and of the cell below it.
        bytes: largest number of bytes of a set.
    """

    def __init__(self, graph: Graph) -> None:
        layout = graph.layout
        self.row = layout.width + 1
        self.bits = [1 << cell + cell // layout.width for cell in range(graph.size)]
        self.open = self.of(set(layout.open_cells.tolist()) - graph.closed)
        self.bytes = self.row * layout.height // 8 + 1
        self._steps_from: dict[int, list[int]] = {}

    def of(self, cells: Iterable[int]) -> int:
        """Return the set of some cells."""
        union = 0
        for cell in cells:
            union |= self.bits[cell]
        return union

    def cell(self, bit: int) -> int:
        """Return the number of the only cell in a set."""
        place = bit.bit_length() - 1
        return place - place // self.row

    def spread(self, cells: int) -> int:
        """Return the cells that a robot can reach in a step, from any of these."""
        row = self.row
        return (cells | cells << 1 | cells >> 1 | cells << row | cells >> row) & self.open

    def steps_from(self, bit: int) -> list[int]:
        """Return the cells that a robot in a cell can reach in a step, each as a set of its own."""
        key = bit.bit_length()
        if key not in self._steps_from:
            self._steps_from[key] = list(bits_of(self.spread(bit)))
        return self._steps_from[key]


def bits_of(cells: int) -> Iterator[int]:
    """Yield the cells of a set, each as a set of its own."""
    while cells:
        bit = cells & -cells
        yield bit
        cells ^= bit
