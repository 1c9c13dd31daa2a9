"""The course of a search over the cells of a layout: what it has marked after each expansion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.search.algorithms import Solution
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

WAITS, UNTOUCHED = -1, 0
"""Marks of a cell on the frontier and of one that has not been reached yet."""

Marks = NDArray[np.int32]
"""``[H, W]``: one of the above, or ``n`` where the n-th expansion, counted from 1, took place."""


class SearchCourse:
    """A search that can be looked at after any number of its expansions.

    Args:
        name: of the algorithm, to be shown.
        layout: that was searched.
        start: the cell that it began with.
        solution: what it found, with its events.

    Raises:
        ValueError: the solution has no events.
    """

    def __init__(
        self, name: str, layout: Layout, start: Cell, solution: Solution[Cell, str]
    ) -> None:
        if len(solution.events) != solution.expanded:
            raise ValueError(
                f"{name} has {len(solution.events)} events of {solution.expanded} expansions; "
                "a search is recorded by with_events=True"
            )
        self.name = name
        self.solution = solution
        self._shape = layout.height, layout.width
        cells, marks, ends = [start], [WAITS], [1]
        for number, (expanded, reached) in enumerate(solution.events, start=1):
            cells += [expanded, *reached]  # type: ignore[list-item] # a state is a cell here
            marks += [number, *[WAITS] * len(reached)]
            ends.append(len(cells))
        rows, columns = np.array(cells).T
        self._cells = rows * layout.width + columns
        self._marks = np.array(marks, dtype=np.int32)
        self._ends = ends

    def __len__(self) -> int:
        return self.solution.expanded

    def is_over(self, count: int) -> bool:
        """Say whether the search has ended by ``count`` expansions."""
        return count >= len(self)

    def marks_after(self, count: int) -> Marks:
        """Return what is marked after ``count`` expansions, or after all where there are fewer."""
        end = self._ends[min(count, len(self))]
        marks = np.full(self._shape, UNTOUCHED, dtype=np.int32)
        # A cell that is reached or expanded again has several marks, and NumPy keeps the last.
        marks.flat[self._cells[:end]] = self._marks[:end]
        if self.is_over(count) and self.solution.found:
            # The goal was taken from the frontier, and is where the expanding ends.
            goal = self.solution.states[-1]
            marks[goal] = max(len(self), 1)
        return marks

    def expanded_by(self, count: int) -> Cell | None:
        """Return the cell of the ``count``-th expansion, none before the first or at the end."""
        if count == 0 or self.is_over(count):
            return None
        row, column = divmod(int(self._cells[self._ends[count - 1]]), self._shape[1])
        return row, column
