"""Space-time A*: the cheapest way of one robot among the reservations of others.

Source: Silver (2005), Cooperative pathfinding, AIIDE.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf
from time import perf_counter
from typing import NamedTuple

import numpy as np

from agents.mapf.graph import CLOSED, Graph
from agents.mapf.reservations import Reservations
from warehouse_core.world.actions import WAIT

NONE = -1
"""Predecessor of the first state."""

Moves = Sequence[Sequence[tuple[int, float, int]]]
"""Steps from each place, waiting the last: the cell that a step leads to, its cost, and its place;
see ``graph.py``.
"""


class Way(NamedTuple):
    """Cell of a robot at each time, and cost of its moves plus the distance that is left."""

    cells: list[int]
    cost: float


def moves_of(graph: Graph) -> Moves:
    """Return the moves of a graph as lists, which Python reads faster; waiting costs 1."""
    headings = WAIT if graph.turn_cost else 1
    costs = np.ones((graph.size, WAIT)) if graph.costs is None else graph.costs
    found = []
    for heading, turns in enumerate(graph.turns[:headings]):
        prices = np.pad(costs, ((0, 0), (0, 1)), constant_values=1) + turns
        places = graph.places_at(np.arange(graph.size), np.full(graph.size, heading))
        columns = (graph.neighbours.tolist(), prices.tolist(), places.tolist())
        found += [
            [move for move in zip(*each, strict=True) if move[0] != CLOSED]
            for each in zip(*columns, strict=True)
        ]
    return found


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
        field: distance of each place from the goal.
        start: place of the robot at ``begin``.
        goal: cell to reach.
        taken: reservations of other robots.
        begin: time of the first cell.
        window: number of steps after which the way may end anywhere, and the distance left counts.
        end: the way does not end in the goal before this time. A robot that is to stay there needs
            ``taken.free_from(goal)``.
        toll: cost of each state or move that another robot has; ``inf`` forbids them.
        deadline: limit on ``time.perf_counter()``.

    Raises:
        TimeoutError: the deadline has passed.
    """
    size, states, swaps = taken.size, taken.states, taken.moves
    places = len(moves)
    ends, closed = taken.ends, taken.closed
    free = end * places
    edge = inf if window is None else (begin + window) * places
    # Without a window all times after the latest are alike, and one layer stands for them.
    last = (max(taken.latest, begin, end) + 1) * places if window is None else inf
    first = begin * places + start
    best, came = {first: 0.0}, {first: NONE}
    heap = [(field[start], -first)]  # of equally good ones the latest is first
    while heap:
        bound, state = heappop(heap)
        state = -state
        time, place = divmod(state, places)
        cost = best[state]
        if bound > cost + field[place]:
            continue
        cell = place % size
        if state >= edge or (cell == goal and state >= free):
            way = []
            while state != NONE:
                way.append(state % size)
                state = came[state]
            return Way(way[::-1], bound)
        if perf_counter() > deadline:
            raise TimeoutError
        after = time + (state < last)
        here, layer, next_layer = (time * size + cell) * size, after * size, after * places
        for to, price, there in moves[place]:
            reached = layer + to
            total, move = cost + price, here + to
            if reached in states or move in swaps:
                if toll == inf:
                    continue
                total += toll
            if reached in closed or (ends and reached >= ends.get(to, inf)):
                continue
            reached = next_layer + there
            if total < best.get(reached, inf):
                best[reached] = total
                came[reached] = state
                heappush(heap, (total + field[there], -reached))
    return None
