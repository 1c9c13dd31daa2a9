"""The way from one cell to another as a search problem; a state is a cell."""

from __future__ import annotations

from collections.abc import Iterable

from agents.floor import Moves, floor_of
from agents.search import Problem
from warehouse_core.layout import MOVE_DELTAS, Cell, Layout, check_open


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
        check_open(layout, start, "start")
        check_open(layout, goal, "goal")
        self.initial = start
        self.goal = goal
        self._floor = floor_of(layout)

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

    def expand(self, state: Cell) -> Moves:
        """Return each move with its result and its cost, as the floor keeps them."""
        return self._floor[state]
