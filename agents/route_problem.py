"""The way from one cell to another as a search problem; a state is a cell."""

from __future__ import annotations

from collections.abc import Iterable

from agents.floor import floor_of
from agents.search import Problem
from warehouse_core.layout import MOVE_DELTAS, Cell, Layout, LayoutError


class RouteProblem(Problem[Cell, str]):
    """Drive from a cell to another, at a cost of one for each move.

    Args:
        layout: the walls.
        start: the cell to begin with.
        goal: the cell to come to.

    Raises:
        LayoutError: one of them is not open.
    """

    def __init__(self, layout: Layout, start: Cell, goal: Cell) -> None:
        for name, cell in (("start", start), ("goal", goal)):
            if not layout.is_open(cell):
                raise LayoutError(f"{name} {layout.describe(cell)}; it must be an open cell")
        self.initial = start
        self.goal = goal
        self._floor = floor_of(layout)
        # What the floor keeps of a cell is what its expansion gives.
        self.expand = self._floor.__getitem__  # type: ignore[assignment, method-assign]

    def is_goal(self, state: Cell) -> bool:
        """Say whether a cell is the goal."""
        return state == self.goal

    def actions(self, state: Cell) -> Iterable[str]:
        """Return the moves that no wall stops."""
        return [move for move, _, _ in self._floor[state]]

    def result(self, state: Cell, action: str) -> Cell:
        """Return the cell that a move leads to."""
        down, right = MOVE_DELTAS[action]
        return state[0] + down, state[1] + right
