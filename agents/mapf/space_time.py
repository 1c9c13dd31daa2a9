"""Space-time A*: the cheapest way of one robot among the reservations of others.

Source: Silver (2005), Cooperative pathfinding, AIIDE.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf
from time import perf_counter
from typing import NamedTuple

from agents.mapf.graph import CLOSED, Graph
from agents.mapf.reservations import Reservations
from warehouse_core.world.actions import WAIT

NONE = -1
"""Before the first state."""

Moves = Sequence[Sequence[tuple[int, float]]]
"""For each cell the cells that a step leads to, itself the last, and what the step costs."""


class Way(NamedTuple):
    """A way of a robot.

    Attributes:
        cells: one for each time.
        cost: of its moves, and the distance that is left.
    """

    cells: list[int]
    cost: float


def moves_of(graph: Graph) -> Moves:
    """Return the moves of a graph as lists, which Python reads faster; waiting costs 1."""
    costs = [[1.0] * WAIT] * graph.size if graph.costs is None else graph.costs.tolist()
    return [
        [(to, price) for to, price in zip(near, (*prices, 1.0), strict=True) if to != CLOSED]
        for near, prices in zip(graph.neighbours.tolist(), costs, strict=True)
    ]


def find_way(
    moves: Moves,
    field: Sequence[float],
    start: int,
    goal: int,
    taken: Reservations,
    begin: int = 0,
    window: int | None = None,
    *,
    end: int = 0,
    toll: float = inf,
    deadline: float = inf,
) -> Way | None:
    """Return the cheapest way from ``start``, or ``None`` if there is none.

    Args:
        moves: see ``moves_of``.
        field: the distance of each cell from the goal.
        start: where the robot is at ``begin``.
        goal: where it is to go.
        taken: by others.
        begin: a time.
        window: after so many steps the way may end anywhere, and only the distance counts.
        end: the way does not end in the goal before this time. A robot that is to stay there needs
            ``taken.free_from(goal)``.
        toll: what each state or move costs that a robot has; ``inf`` forbids them.
        deadline: by ``time.perf_counter``.

    Raises:
        TimeoutError: the deadline has passed.
    """
    size, states, swaps = taken.size, taken.states, taken.moves
    ends, closed, closed_moves = taken.ends, taken.closed, taken.closed_moves
    free = end * size
    edge = inf if window is None else (begin + window) * size
    # Without a window all times after the latest are alike, and one layer stands for them.
    last = (max(taken.latest, begin, end) + 1) * size if window is None else inf
    first = begin * size + start
    best, came = {first: 0.0}, {first: NONE}
    heap = [(field[start], -first)]  # of equally good ones the latest is first
    while heap:
        bound, state = heappop(heap)
        state = -state
        cell = state % size
        cost = best[state]
        if bound > cost + field[cell]:
            continue
        if state >= edge or (cell == goal and state >= free):
            return Way(_trace(came, state, size), bound)
        if perf_counter() > deadline:
            raise TimeoutError
        time_after = state - cell + (size if state < last else 0)
        for to, price in moves[cell]:
            reached = time_after + to
            total, move = cost + price, state * size + to
            if reached in states or move in swaps:
                if toll == inf:
                    continue
                total += toll
            if reached in closed or move in closed_moves or (ends and reached >= ends.get(to, inf)):
                continue
            if total < best.get(reached, inf):
                best[reached] = total
                came[reached] = state
                heappush(heap, (total + field[to], -reached))
    return None


def _trace(came: dict[int, int], state: int, size: int) -> list[int]:
    way = []
    while state != NONE:
        way.append(state % size)
        state = came[state]
    return way[::-1]
