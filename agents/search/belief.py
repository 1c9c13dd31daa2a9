"""The belief of a robot without a map, which assumes that all unseen cells are free."""

from __future__ import annotations

from collections.abc import Sequence

from agents.search.problems import GridProblem, MoveTable
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import EMPTY, WALL, Cell


class Belief:
    """The cells that a robot has seen. Unseen cells are believed to be free, except for bumps.

    Attributes:
        known: tile of each cell that has been seen, ``"#"`` or ``"."``.
        news: part of ``known`` that the last call of ``look`` added.
        bumps: unseen cells that two successive moves failed to reach, which are probably walls.
        moves: moves from each cell to the neighbours that are believed to be free.
        rows: range of rows that contains all cells of ``known`` and ``bumps`` and the ends of all
            routes.
        cols: range of columns that contains the same cells.
    """

    def __init__(self) -> None:
        self.known: dict[Cell, str] = {}
        self.news: dict[Cell, str] = {}
        self.bumps: set[Cell] = set()
        self.moves = MoveTable(self.is_free)
        self.rows = self.cols = range(0)
        self._failed: set[Cell] = set()

    def look(self, observation: Observation) -> None:
        """Add the cells in view to the belief."""
        self.news = {
            cell: WALL if tile == WALL else EMPTY
            for cell, tile in cells_in_view(observation).items()
            if cell not in self.known
        }
        self.known |= self.news
        self.include(*self.news)
        for cell, tile in self.news.items():
            if tile == WALL or cell in self.bumps:
                self.moves.recompute(cell)

    def bump(self, cell: Cell) -> None:
        """Record that a move to a cell did not reach it.

        Only the second failure in a row counts as a bump, because a robot that slipped may reach
        the cell at its next attempt.
        """
        if cell in self._failed and cell not in self.known:
            self.bumps.add(cell)
            self.moves.recompute(cell)
            self.include(cell)
        self._failed = {cell}

    def forget_bumps(self) -> None:
        """Assume again that the cells of ``bumps`` are free."""
        while self.bumps:
            self.moves.recompute(self.bumps.pop())

    def include(self, *cells: Cell) -> None:
        """Extend ``rows`` and ``cols`` to contain these cells."""
        if cells:
            rows, cols = zip(*cells, strict=True)
            self.rows, self.cols = _extended(self.rows, rows), _extended(self.cols, cols)

    def is_free(self, cell: Cell) -> bool:
        """Return whether a cell is believed to be free."""
        return self.known.get(cell) != WALL and (cell in self.known or cell not in self.bumps)


class BeliefProblem(GridProblem[Cell]):
    """The problem of driving from ``start`` to ``goal`` through cells that are believed to be free.

    All cells outside the rows and columns of the belief are believed to be free. A shortest path
    therefore never leaves them by more than one cell, and the search is limited to this area.
    """

    def __init__(self, belief: Belief, start: Cell, goal: Cell) -> None:
        self.initial = start
        self.goal = goal
        belief.include(start, goal)
        self._moves, self._rows, self._cols = belief.moves, belief.rows, belief.cols

    def is_goal(self, state: Cell) -> bool:
        """Return whether a cell is the goal."""
        return state == self.goal

    def expand(self, state: Cell) -> Sequence[tuple[str, Cell, float]]:
        """Return each move to a cell that is believed to be free."""
        row, col = state
        if row in self._rows and col in self._cols:
            return self._moves[state]
        return [edge for edge in self._moves[state] if self._is_within(edge[1])]

    def _is_within(self, cell: Cell) -> bool:
        """Return whether a cell is at most one cell outside the rows and columns of the belief."""
        spans = zip(cell, (self._rows, self._cols), strict=True)
        return all(span.start - 1 <= number <= span.stop for number, span in spans)


def cells_in_view(observation: Observation) -> dict[Cell, str]:
    """Return the character of each cell in the window of an observation."""
    window = observation["local_grid"]
    radius = len(window) // 2
    row, col = observation["robot_pos"]
    return {
        (down, right): tile
        for down, line in enumerate(window, start=row - radius)
        for right, tile in enumerate(line, start=col - radius)
    }


def _extended(span: range, numbers: Sequence[int]) -> range:
    """Return the smallest range that contains a range and some more numbers."""
    ends = [*numbers, span[0], span[-1]] if span else numbers
    return range(min(ends), max(ends) + 1)
