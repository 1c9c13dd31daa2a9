"""Space-time A*: the cheapest way of one robot among the ways of others, which are reserved.

A cell at a time is one number, a *state*: ``time * H * W + cell``.

Source: Silver (2005), Cooperative pathfinding, AIIDE.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf
from time import perf_counter

import numpy as np

from agents.mapf.graph import CLOSED, Graph

NONE = -1
"""Predecessor of the first state."""

Moves = Sequence[Sequence[tuple[int, float]]]
"""Steps from each cell, waiting the last: the cell that a step leads to, and its cost."""


class Reservations:
    """The states and moves that are taken on a floor of ``H * W`` cells, its size.

    Attributes:
        states: taken states.
        moves: ``state * H * W + cell`` of the moves that would make a robot change places with
            another.
        ends: the state from which on a cell is occupied for good, by cell.
        free_from: the time from which on nobody is in a cell, by cells that are no ends.
        latest: time after which nothing is taken but for good.
    """

    def __init__(self, size: int) -> None:
        self.size, self.latest = size, 0
        self.states: set[int] = set()
        self.moves: set[int] = set()
        self.ends: dict[int, int] = {}
        self.free_from = defaultdict[int, int](int)

    def add(self, way: list[int]) -> None:
        """Reserve the way of a robot: its cell at each time, the last one for good."""
        state, before = 0, way[0]
        for time, cell in enumerate(way, 1):
            self.states.add(state + cell)
            self.moves.add((state - self.size + cell) * self.size + before)
            self.free_from[cell] = max(self.free_from[cell], time)
            state, before = state + self.size, cell
        self.latest = max(self.latest, len(way) - 1)
        self.ends[way[-1]] = (len(way) - 1) * self.size + way[-1]


def moves_of(graph: Graph) -> Moves:
    """Return the moves of a graph as lists, which Python reads faster; waiting costs 1."""
    costs = np.ones((graph.size, len(graph.turns) + 1))
    if graph.costs is not None:
        costs[:, :-1] = graph.costs
    pairs = zip(graph.neighbours.tolist(), costs.tolist(), strict=True)
    return [[move for move in zip(*each, strict=True) if move[0] != CLOSED] for each in pairs]


def find_way(
    moves: Moves,
    field: Sequence[float],
    start: int,
    goal: int,
    taken: Reservations,
    deadline: float = inf,
) -> list[int] | None:
    """Return the cells of the cheapest way to a goal where the robot can stay, one for each time.

    Args:
        moves: see ``moves_of``.
        field: distance of each cell from the goal.
        start: cell of the robot at the time 0.
        goal: cell to reach.
        taken: reservations of other robots.
        deadline: limit on ``time.perf_counter()``.

    Returns:
        The way, or ``None`` if there is none.

    Raises:
        TimeoutError: the deadline has passed.
    """
    size, states, swaps, ends = taken.size, taken.states, taken.moves, taken.ends
    free = taken.free_from[goal] * size
    last = (taken.latest + 1) * size  # all later times are alike, and one layer stands for them
    best, came = {start: 0.0}, {start: NONE}
    heap = [(field[start], -start)]  # of equally good ones the latest is first
    while heap:
        bound, state = heappop(heap)
        state = -state
        time, cell = divmod(state, size)
        cost = best[state]
        if bound > cost + field[cell]:
            continue
        if cell == goal and state >= free:
            way = []
            while state != NONE:
                way.append(state % size)
                state = came[state]
            return way[::-1]
        if perf_counter() > deadline:
            raise TimeoutError
        here, layer = state * size, (time + (state < last)) * size
        for to, price in moves[cell]:
            reached, total = layer + to, cost + price
            if reached in states or here + to in swaps or reached >= ends.get(to, inf):
                continue
            if total < best.get(reached, inf):
                best[reached] = total
                came[reached] = state
                heappush(heap, (total + field[to], -reached))
    return None
