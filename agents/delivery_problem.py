"""The delivery of an item as a search problem.

A state is ``(row, col, has_item)``, and ``DELIVERED`` once the item has been dropped. The
transition model is that of ``warehouse_core/rules.py`` for a robot that goes where it is told.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from agents.action_costs import ONE_EACH, ActionCosts
from agents.floor import floor_of
from agents.search import Problem
from warehouse_core.layout import MOVE_DELTAS, Cell, Layout, check_open

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
