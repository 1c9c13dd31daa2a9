"""Proofs that a problem on a small floor has no plan, because robots cannot pass each other.

Two robots are followed. All others are alike, so that they may be anywhere in each *part*, the
cells that are connected without the cells of the two; only their number in it counts. A robot moves
into a part that has a free cell, or one or both turn with a ring. If the two cannot get to their
goals in this way, no plan exists.

More is taken to be possible than may be: a ring may not have room, and the others are not alike.
So a problem without a proof need not have a plan, but one with a proof has none.

Source: Kornhauser, Miller and Spirakis (1984), Coordinating pebble motion on graphs, FOCS, on which
pairs can change places; Yu and Rus (2014), Pebble motion on graphs with rotations, WAFR, on rings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cache, lru_cache
from itertools import combinations, product

from agents.errors import PlanError
from agents.mapf.graph import CLOSED, Graph
from agents.mapf.problem import Problem
from warehouse_core.world.actions import WAIT

__all__ = ["check_solvable"]

MAX_CELLS = 64
"""Open cells up to which a proof is looked for."""

MAX_STATES = 3000
"""States after which a search for a proof is given up, after a fraction of a second."""

Cells = int
"""A set of cells, the bits of a number."""

State = tuple[int, int, tuple[int, ...]]
"""The cells of two robots, and the number of free cells in each part."""


def check_solvable(problem: Problem) -> None:
    """Look for a proof that a problem has no plan.

    Raises:
        PlanError: there is none; the message names two robots that cannot get to their goals.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from agents.mapf.solvable import check_solvable
        >>> from warehouse_core import Layout
        >>> check_solvable(Problem(Graph(Layout(["..."])), starts=[0, 2], goals=[2, 0]))
        Traceback (most recent call last):
            ...
        agents.errors.PlanError: there is no plan: robots 0 and 1 cannot pass each other and ...
    """
    if len(problem.graph.layout.open_cells) > MAX_CELLS:
        return
    moves, known = PairMoves(problem.graph), list[set[State]]()
    for one, other in combinations(range(problem.robots), 2):
        start = moves.state(one, other, problem.starts)
        reached = next((states for states in known if start in states), None)
        if reached is None:
            reached = _reach(moves, start, MAX_STATES - sum(map(len, known)))
            known.append(reached)
        if not reached:
            return
        if moves.state(one, other, problem.goals) not in reached:
            raise PlanError(
                f"there is no plan: robots {one} and {other} cannot pass each other and the rest "
                "on the way to their goals"
            )


def _reach(moves: PairMoves, start: State, most: int) -> set[State]:
    """Return all states that can be reached from one, or none if there are too many."""
    reached, stack = {start}, [start]
    while stack:
        if len(reached) > most:
            return set()
        new = set(moves.after(stack.pop())) - reached
        reached |= new
        stack += new
    return reached


class PairMoves:
    """The moves of two robots on a floor, when all others are alike."""

    def __init__(self, graph: Graph) -> None:
        cells = graph.layout.open_cells.tolist()
        beside = {cell: graph.neighbours[cell, :WAIT] for cell in cells}
        self._beside = {cell: _set_of(row[row != CLOSED]) for cell, row in beside.items()}
        self._open = _set_of(cells)
        self.parts = cache(self._parts)

    def state(self, one: int, other: int, cells: Sequence[int]) -> State:
        """Return the state of two robots when all robots are in some cells."""
        pair, free = (int(cells[one]), int(cells[other])), self._open & ~_set_of(cells)
        return *pair, tuple((part & free).bit_count() for part in self.parts(*pair))

    def after(self, state: State) -> Iterator[State]:
        """Return the states after a move of a robot into a part, and after a ring."""
        one, other, free = state
        parts = self.parts(one, other)
        for number, (part, count) in enumerate(zip(parts, free, strict=True)):
            less = *free[:number], count - 1, *free[number + 1 :]
            for mover in (one, other):
                ways = self._beside[mover] & part
                for to in _cells_of(ways):
                    pair = (to, other) if mover == one else (one, to)
                    if count:
                        yield from self._spread(pair, parts, less, left=1 << mover)
                    if ways.bit_count() > 1:
                        yield from self._spread(pair, parts, free)
        for to, then in product(*(_cells_of(self._beside[cell]) for cell in (one, other))):
            if self._is_ring(one, other, to, then):
                yield from self._spread((to, then), parts, free)

    def _is_ring(self, one: int, other: int, to: int, then: int) -> bool:
        """Return whether a ring may move two robots at once to these cells."""
        parts = self.parts(one, other)
        first, second = (next((part for part in parts if part >> at & 1), 0) for at in (to, then))
        closes = (second & self._beside[one]).bit_count(), (first & self._beside[other]).bit_count()
        if to == other:
            return closes[0] > 0  # then is not one, or there would be no part
        if then == one:
            return closes[1] > 0
        return to != then and min(closes) > (first == second)

    def _spread(
        self, pair: tuple[int, int], parts: Sequence[Cells], free: tuple[int, ...], left: Cells = 0
    ) -> Iterator[State]:
        """Return the states in which free cells are anywhere in what remains of their parts.

        ``left`` is a cell that has become free, or none.
        """
        new = self.parts(*pair)
        ways = [
            _shares(count, tuple((part & to).bit_count() for to in new))
            for part, count in zip(parts, free, strict=True)
        ]
        gained = tuple((part & left).bit_count() for part in new)
        for chosen in product(*ways):
            yield *pair, tuple(map(sum, zip(gained, *chosen, strict=True)))

    def _parts(self, one: int, other: int) -> list[Cells]:
        rest, parts = self._open & ~_set_of([one, other]), list[Cells]()
        while rest:
            part, edge = 0, rest & -rest
            while edge:
                part |= edge
                beside = 0
                for cell in _cells_of(edge):
                    beside |= self._beside[cell]
                edge = beside & rest & ~part
            parts.append(part)
            rest &= ~part
        return parts


@lru_cache(10_000)
def _shares(count: int, rooms: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Return all ways to divide a number of free cells among rooms of these sizes."""
    if not rooms:
        return [] if count else [()]
    return [
        (first, *rest)
        for first in range(min(count, rooms[0]) + 1)
        for rest in _shares(count - first, rooms[1:])
    ]


def _set_of(cells: Iterable[int]) -> Cells:
    return sum(1 << int(cell) for cell in cells)


def _cells_of(cells: Cells) -> Iterator[int]:
    while cells:
        yield (cells & -cells).bit_length() - 1
        cells &= cells - 1
