"""What a robot believes of a warehouse that it has not been shown: all that it has seen."""

from __future__ import annotations

from collections.abc import Iterable

from agents.search.algorithms import Problem
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import EMPTY, MOVE_DELTAS, WALL, Cell


class Belief:
    """The cells that have been seen; every other is believed to be free until it is seen.

    Attributes:
        known: what has been seen, ``"#"`` or ``"."``, by the cell.
        bumps: cells that two moves in a row have not got to, and that have not been seen: walls,
            as a guess.
    """

    def __init__(self) -> None:
        self.known: dict[Cell, str] = {}
        self.bumps: set[Cell] = set()
        self._failed: set[Cell] = set()

    def look(self, observation: Observation) -> None:
        """Take in what is seen."""
        window = observation["local_grid"]
        radius = len(window) // 2
        row, col = observation["robot_pos"]
        for down, line in enumerate(window, start=row - radius):
            for right, tile in enumerate(line, start=col - radius):
                self.known[down, right] = WALL if tile == WALL else EMPTY

    def bump(self, cell: Cell) -> None:
        """Take in that a move to a cell has not got there.

        Once is no proof: a robot that slips may get there when it tries again.
        """
        if cell in self._failed and cell not in self.known:
            self.bumps.add(cell)
        self._failed = {cell}

    def is_free(self, cell: Cell) -> bool:
        """Say whether a cell may be free, for all that is known."""
        return self.known.get(cell) != WALL and (cell in self.known or cell not in self.bumps)


class BeliefProblem(Problem[Cell, str]):
    """Drive to a cell through what is believed to be free.

    Beyond all that has been seen everything is believed to be free, so that no way need ever lead
    further out than one cell: the search stays within that.

    Args:
        belief: what is known.
        start: the cell of the robot.
        goal: the cell to come to.
    """

    def __init__(self, belief: Belief, start: Cell, goal: Cell) -> None:
        self.initial = start
        self.goal = goal
        self._belief = belief
        rows, cols = zip(start, goal, *belief.known, strict=True)
        self._rows = range(min(rows) - 1, max(rows) + 2)
        self._cols = range(min(cols) - 1, max(cols) + 2)

    def is_goal(self, state: Cell) -> bool:
        """Say whether a cell is the goal."""
        return state == self.goal

    def actions(self, state: Cell) -> Iterable[str]:
        """Return the moves that no known wall stops."""
        for move in MOVE_DELTAS:
            row, col = cell = self.result(state, move)
            if row in self._rows and col in self._cols and self._belief.is_free(cell):
                yield move

    def result(self, state: Cell, action: str) -> Cell:
        """Return the cell that a move leads to."""
        down, right = MOVE_DELTAS[action]
        return state[0] + down, state[1] + right
