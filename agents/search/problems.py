"""Search problems on a layout: the route to a cell, and the delivery of an item.

Both take their moves from a ``MoveTable``, which all problems with the same walls share. The
transition model follows the table in ``warehouse_core/task/rules.py`` for a robot whose moves
always succeed. It is implemented in ``expand``, on which the other methods are based.

A state of a route is a cell. A state of a delivery is ``(row, col, has_item)``, or ``DELIVERED``
after the drop.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import lru_cache

from agents.search.algorithms import Problem, S
from agents.search.costs import ONE_EACH, ActionCosts
from warehouse_core.arguments import as_cell, flag, instance_of, sequence_of
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tiles import MOVE_DELTAS, NO_STATIONS, Cell, moved

Edges = tuple[tuple[str, Cell, float], ...]
"""The result of EXPAND for a cell: each open move, the cell to which it leads, and the cost 1.0."""

DeliveryState = tuple[int, int, bool]

DELIVERED: DeliveryState = (-1, -1, False)
"""The state after the drop, wherever the robot is."""


class MoveTable(dict[Cell, Edges]):
    """The open moves from each cell, computed when a cell is looked up for the first time.

    Equal cells in a table are the same object, because dictionaries find identical keys faster.
    """

    def __init__(self, is_open: Callable[[Cell], bool]) -> None:
        super().__init__()
        self._is_open = is_open
        self._cells: dict[Cell, Cell] = {}

    def __missing__(self, cell: Cell) -> Edges:
        neighbours = ((move, moved(cell, delta)) for move, delta in MOVE_DELTAS.items())
        same = self._cells.setdefault
        moves = self[same(cell, cell)] = tuple(
            (move, same(ahead, ahead), 1.0) for move, ahead in neighbours if self._is_open(ahead)
        )
        return moves

    def recompute(self, cell: Cell) -> None:
        """Update the table after a cell has become open or closed."""
        # Only the neighbours have a move to this cell. Their moves are computed again when needed.
        for delta in MOVE_DELTAS.values():
            self.pop(moved(cell, delta), None)


def move_table(layout: Layout) -> MoveTable:
    """Return the move table of a layout. Layouts with the same walls share a table."""
    return _table(tuple(row.translate(NO_STATIONS) for row in layout.rows))


@lru_cache(maxsize=8)
def _table(walls: tuple[str, ...]) -> MoveTable:
    return MoveTable(Layout(walls).is_open)


class GridProblem(Problem[S, str]):
    """A problem on a grid whose actions are words."""

    @abstractmethod
    def expand(self, state: S) -> Sequence[tuple[str, S, float]]:
        """Return each action that has an effect, with its result and its cost."""

    def actions(self, state: S) -> list[str]:
        """Return the actions that have an effect."""
        return [action for action, _, _ in self.expand(state)]

    def result(self, state: S, action: str) -> S:
        """Return the state after one of ``actions``."""
        return {each: to for each, to, _ in self.expand(state)}[action]

    def action_cost(self, state: S, action: str, successor: S) -> float:
        """Return the cost of one of ``actions``."""
        return {each: cost for each, _, cost in self.expand(state)}[action]


class RouteProblem(GridProblem[Cell]):
    """The problem of driving from ``start`` to ``goal`` on a layout. Each move costs 1.

    Raises:
        LayoutError: the start or the goal is not an open cell.

    Example:
        >>> from agents.search import RouteProblem
        >>> from warehouse_core import Layout
        >>> problem = RouteProblem(Layout(["P.#", "..D"]), start=(0, 0), goal=(1, 2))
        >>> list(problem.actions((0, 0))), problem.result((0, 0), "E")
        (['E', 'S'], (0, 1))
    """

    def __init__(self, layout: Layout, start: Cell, goal: Cell) -> None:
        instance_of("layout", layout, Layout)
        self.initial, self.goal = as_cell("start", start), as_cell("goal", goal)
        check_open(layout, self.initial, "start")
        check_open(layout, self.goal, "goal")
        self._moves = move_table(layout)

    def is_goal(self, state: Cell) -> bool:
        """Return whether a cell is the goal."""
        return state == self.goal

    def expand(self, state: Cell) -> Edges:
        """Return each open move with its result and cost."""
        return self._moves[state]


def _stations(name: str, cells: Sequence[Cell]) -> frozenset[Cell]:
    sequence_of(name, cells, object)
    return frozenset(as_cell(name, cell) for cell in cells)


class DeliveryProblem(GridProblem[DeliveryState]):
    """The problem of picking the item up at a pickup and dropping it at a dropoff.

    Args:
        layout: layout with the walls and the default stations.
        start: cell of the robot.
        has_item: true if the robot already holds the item.
        pickups: cells where the item can be picked up; ``None`` means the pickups of the layout.
        dropoffs: cells where it can be delivered; ``None`` means the dropoffs of the layout.
        costs: costs of the actions.

    Raises:
        LayoutError: the start or a station is not an open cell.

    Example:
        >>> from agents.search import DeliveryProblem, uniform_cost_search
        >>> from warehouse_core import Layout
        >>> uniform_cost_search(DeliveryProblem(Layout(["P.#", "..D"]), (0, 1))).actions
        ('W', 'PICK', 'S', 'E', 'E', 'DROP')
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
        instance_of("layout", layout, Layout)
        start = as_cell("start", start)
        self.initial = (*start, flag("has_item", has_item))
        self.size = layout.height, layout.width
        self.pickups = _stations("pickups", layout.pickups if pickups is None else pickups)
        self.dropoffs = _stations("dropoffs", layout.dropoffs if dropoffs is None else dropoffs)
        instance_of("costs", costs, ActionCosts)
        check_open(layout, start, "start")
        for name, cells in (("pickup", self.pickups), ("dropoff", self.dropoffs)):
            for cell in cells:
                check_open(layout, cell, name)
        self.costs = costs
        self._moves = move_table(layout)

    def is_goal(self, state: DeliveryState) -> bool:
        """Return whether the item has been delivered."""
        return state == DELIVERED

    def expand(self, state: DeliveryState) -> list[tuple[str, DeliveryState, float]]:
        """Return each open move, and ``PICK`` or ``DROP`` where it has an effect."""
        row, col, has_item = state
        if state == DELIVERED:
            return []
        cost = self.costs.move_loaded if has_item else self.costs.move_empty
        edges = [(move, (*cell, has_item), cost) for move, cell, _ in self._moves[row, col]]
        if has_item and (row, col) in self.dropoffs:
            edges.append(("DROP", DELIVERED, self.costs.drop))
        if not has_item and (row, col) in self.pickups:
            edges.append(("PICK", (row, col, True), self.costs.pick))
        return edges
