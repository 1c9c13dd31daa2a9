"""The delivery of an item as a search problem.

A state is ``(row, col, has_item)``, and ``DELIVERED`` once the item has been dropped. The
transition model is that of ``warehouse_core/task/rules.py`` for a robot that goes where it is told.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

from agents.search.algorithms import Problem
from agents.search.costs import ONE_EACH, ActionCosts
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tiles import DROPOFF, EMPTY, MOVE_DELTAS, PICKUP, Cell


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


Moves = tuple[tuple[str, Cell, float], ...]
"""Each move that no wall stops, the cell that it leads to, and its cost in steps: EXPAND."""


class Floor(dict[Cell, Moves]):
    """The moves from every cell of some walls, worked out when a cell is first asked for."""

    def __init__(self, walls: Layout) -> None:
        super().__init__()
        self._walls = walls

    def __missing__(self, cell: Cell) -> Moves:
        row, col = cell
        moves = self[cell] = tuple(
            (move, (row + down, col + right), 1.0)
            for move, (down, right) in MOVE_DELTAS.items()
            if self._walls.is_open((row + down, col + right))
        )
        return moves


def floor_of(layout: Layout) -> Floor:
    """Return the floor of a layout, the same one for all that have its walls."""
    return _floor(tuple(row.replace(PICKUP, EMPTY).replace(DROPOFF, EMPTY) for row in layout.rows))


@lru_cache(maxsize=8)
def _floor(walls: tuple[str, ...]) -> Floor:
    return Floor(Layout(walls))


State = tuple[int, int, bool]

DELIVERED: State = (-1, -1, False)
"""The item has arrived, wherever the robot is."""


class DeliveryProblem(Problem[State, str]):
    """Pick the item up at a pickup and drop it at a dropoff.

    Args:
        layout: the walls, and the stations where no others are given.
        start: the cell of the robot.
        has_item: whether it holds the item already.
        pickups: where the item can be had.
        dropoffs: where it can be delivered.
        costs: of the actions.

    Raises:
        LayoutError: the start or a station is not open.
    """

    def __init__(
        self,
        layout: Layout,
        start: Cell,
        has_item: bool = False,
        *,
        pickups: Sequence[Cell] | None = None,
        dropoffs: Sequence[Cell] | None = None,
        costs: ActionCosts = ONE_EACH,
    ) -> None:
        self.layout = layout
        self.initial = (*start, has_item)
        self.pickups = frozenset(layout.pickups if pickups is None else pickups)
        self.dropoffs = frozenset(layout.dropoffs if dropoffs is None else dropoffs)
        check_open(layout, start, "start")
        for name, cells in (("pickup", self.pickups), ("dropoff", self.dropoffs)):
            for cell in cells:
                check_open(layout, cell, name)
        self.costs = costs
        self._floor = floor_of(layout)

    def is_goal(self, state: State) -> bool:
        """Say whether the item has been delivered."""
        return state == DELIVERED

    def actions(self, state: State) -> Iterable[str]:
        """Return the moves that no wall stops, and ``PICK`` or ``DROP`` where they do something."""
        return [action for action, _, _ in self.expand(state)]

    def result(self, state: State, action: str) -> State:
        """Return the state after an action."""
        row, col, has_item = state
        if action == "DROP":
            return DELIVERED
        if action == "PICK":
            return row, col, True
        down, right = MOVE_DELTAS[action]
        return row + down, col + right, has_item

    def action_cost(self, state: State, action: str, successor: State) -> float:
        """Return what an action costs."""
        if action in MOVE_DELTAS:
            return self.costs.move_loaded if state[2] else self.costs.move_empty
        return self.costs.drop if action == "DROP" else self.costs.pick

    def expand(self, state: State) -> list[tuple[str, State, float]]:
        """Return each action with its result and its cost."""
        row, col, has_item = state
        if state == DELIVERED:
            return []
        cost = self.costs.move_loaded if has_item else self.costs.move_empty
        found = [(move, (*cell, has_item), cost) for move, cell, _ in self._floor[row, col]]
        if has_item and (row, col) in self.dropoffs:
            found.append(("DROP", DELIVERED, self.costs.drop))
        if not has_item and (row, col) in self.pickups:
            found.append(("PICK", (row, col, True), self.costs.pick))
        return found
