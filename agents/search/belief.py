"""The belief of a robot without a map: the cells that it has seen, and that others are free."""

from __future__ import annotations

from collections.abc import Iterable

from agents.search.algorithms import Problem
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import EMPTY, MOVE_DELTAS, WALL, Cell, moved


class Belief:
    """The cells that have been seen; every other cell is believed to be free.

    Attributes:
        known: the tile of each cell that has been seen, ``"#"`` or ``"."``.
        bumps: cells that have not been seen and that two successive moves did not reach; probably
            walls.
    """

    def __init__(self) -> None:
        self.known: dict[Cell, str] = {}
        self.bumps: set[Cell] = set()
        self._failed: set[Cell] = set()

    def look(self, observation: Observation) -> None:
        """Add the cells in view."""
        window = observation["local_grid"]
        radius = len(window) // 2
        row, col = observation["robot_pos"]
        for down, line in enumerate(window, start=row - radius):
            for right, tile in enumerate(line, start=col - radius):
                self.known[down, right] = WALL if tile == WALL else EMPTY

    def bump(self, cell: Cell) -> None:
        """Note that a move to a cell did not reach it.

        One failure is no proof: a robot that slips may reach the cell at the next attempt.
        """
        if cell in self._failed and cell not in self.known:
            self.bumps.add(cell)
        self._failed = {cell}

    def is_free(self, cell: Cell) -> bool:
        """Return whether a cell is believed to be free."""
        return self.known.get(cell) != WALL and (cell in self.known or cell not in self.bumps)


class BeliefProblem(Problem[Cell, str]):
    """Drive from ``start`` to ``goal`` through cells that are believed to be free.

    All cells outside the seen ones are believed to be free, so no shortest path leads further out
    than one cell; the search is limited to that.
    """

    def __init__(self, belief: Belief, start: Cell, goal: Cell) -> None:
        self.initial = start
        self.goal = goal
        self._belief = belief
        rows, cols = zip(start, goal, *belief.known, strict=True)
        self._rows = range(min(rows) - 1, max(rows) + 2)
        self._cols = range(min(cols) - 1, max(cols) + 2)

    def is_goal(self, state: Cell) -> bool:
        """Return whether a cell is the goal."""
        return state == self.goal

    def actions(self, state: Cell) -> Iterable[str]:
        """Return the moves to cells that are believed to be free."""
        for move, delta in MOVE_DELTAS.items():
            row, col = cell = moved(state, delta)
            if row in self._rows and col in self._cols and self._belief.is_free(cell):
                yield move

    def result(self, state: Cell, action: str) -> Cell:
        """Return the cell that a move leads to."""
        return moved(state, MOVE_DELTAS[action])
