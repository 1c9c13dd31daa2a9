"""Ways out for a fleet that is stuck: moves of some robots, one after the other.

In a narrow place robots may wait for each other, or for people who wait for them, for ever. A
search over the cells of the robots and people around one robot finds how it gets to its goal.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from agents.mapf.assignment import NONE
from agents.mapf.graph import CLOSED, Fields
from agents.mapf.kernels.places import FAR
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

PATIENCE = 6
"""Steps of a cell in which no robot gets nearer to its goal, from which on a fleet is stuck."""

STANDS = 4
"""Steps of a cell in which no robot moves, from which on moves are planned anew."""

MAX_OTHERS, MAX_STATES, MAX_CHIEFS = 10, 40_000, 2
"""Limits of a plan: robots and people who move besides one robot, states that the search expands,
and robots for which a plan is searched."""

PERSON_ON, PERSON_BACK = 2, 6
"""Costs of a step of a person, in moves of robots: towards a station, and back; every other time
the other way round, since people may want something else."""

MEMORY = 0.8
"""Factor by which the progress of people counts less with each step."""

IN_THE_WAY = 3
"""Estimate of the moves that make room where somebody is on the way of the robot."""

GREED = 2
"""Weight of the steps to the goal against the moves so far."""


class State(NamedTuple):
    """Cells of the robot that is to reach its goal, of other robots, and of people."""

    chief: int
    robots: frozenset[int]
    people: tuple[int, ...]

    def moved(self, start: int, end: int) -> State:
        """Return the state after somebody has moved from a cell to another."""
        if start == self.chief:
            return self._replace(chief=end)
        if start in self.robots:
            return self._replace(robots=self.robots - {start} | {end})
        return self._replace(people=tuple(end if at == start else at for at in self.people))


class Move(NamedTuple):
    """A step of a robot, by its number, or of a person, whose number is ``NONE`` or less."""

    who: int
    start: int
    end: int


class Escapes:
    """Plans moves of robots when a fleet is stuck, and has them made.

    A fleet is stuck if no robot has come nearer to its goal than it was since a robot last picked,
    dropped or charged. Then moves are planned with which a robot reaches its goal, one after the
    other. People in them walk to stations, or back; robots wait for them to do it.

    Args:
        fields: distances on the floor, in steps.
        robots: ``R``.
        cell_steps: steps in which a robot crosses a cell.

    Attributes:
        held: robots that make no move but those that are planned.
    """

    def __init__(self, fields: Fields, robots: int, cell_steps: float = 1.0) -> None:
        self._patience, self._most_stands = PATIENCE * cell_steps, STANDS * cell_steps
        graph = fields.graph
        sides: list[list[int]] = graph.neighbours[:, :WAIT].tolist()
        self._fields = fields
        self._near = [[each for each in beside if each != CLOSED] for beside in sides]
        layout = graph.layout
        stations = [*layout.pickups, *layout.dropoffs, *layout.chargers]
        self._stations = layout.numbers(stations)
        self._people: Integers = np.empty(0, np.intp)
        self._progress = np.zeros((len(self._stations), 0))
        self._nearest = np.full(robots, FAR)
        self._cells = np.full(robots, NONE)
        self._waits = self._stands = self._tries = 0
        self._moves: list[Move] = []
        self.held: list[int] = []

    def aims(
        self, cells: Integers, goals: Integers, ways: Integers, walls: set[int], people: Integers,
        has_worked: bool,
    ) -> dict[int, int]:  # fmt: skip
        """Return where robots are to be after this step, by robot; the others go as they want to.

        Args:
            cells: ``[R]`` cells of the robots.
            goals: ``[R]`` cells where the robots have something to do.
            ways: ``[R]`` steps to these, ``FAR`` for robots that have nothing to do.
            walls: cells of robots that stay for long, and others that are closed.
            people: cells of people.
            has_worked: a robot picks, drops, or begins or ends to charge.
        """
        self._watch(people)
        if has_worked:
            self._nearest[:] = FAR
            self._tries = 0
        is_nearer = ways < self._nearest
        self._nearest[is_nearer] = ways[is_nearer]
        self._waits = 0 if has_worked or is_nearer.any() else self._waits + 1
        self._stands = self._stands + 1 if np.array_equal(cells, self._cells) else 0
        self._cells = cells.copy()
        where, persons = cells.tolist(), people.tolist()
        if self._stands >= self._most_stands if self._moves else self._waits >= self._patience:
            self._waits = self._stands = 0
            self._tries += 1
            self._moves = self._plan(where, goals, ways, walls, persons)
        while self._moves and self._is_made(self._moves[0], where, persons):
            self._moves.pop(0)
        if not self._moves:
            self.held = []
        found, taken = {robot: where[robot] for robot in self.held}, {*where, *persons, *walls}
        for who, start, end in self._moves:
            if who < 0 or found[who] != start or where[who] != start or end in taken:
                break
            found[who] = end
            taken = taken - {start} | {end}
        return found

    def _is_made(self, move: Move, where: list[int], people: list[int]) -> bool:
        return where[move.who] == move.end if move.who >= 0 else people[~move.who] != move.start

    def _watch(self, people: Integers) -> None:
        """Note to which stations people seem to walk."""
        if not len(people):
            return
        if len(people) != len(self._people):
            self._progress, self._people = np.zeros((len(self._stations), len(people))), people
        rows = self._fields.rows(self._stations)[:, None]
        matrix = self._fields.matrix
        self._progress[:, people != self._people] *= MEMORY
        self._progress += matrix[rows, self._people] - matrix[rows, people]
        self._progress[self._stations[:, None] == people] = 0
        self._people = people

    def _plan(
        self, where: list[int], goals: Integers, ways: Integers, walls: set[int], people: list[int]
    ) -> list[Move]:
        """Return moves that lead one of the robots that are nearest to their goals there."""
        chiefs = np.argsort(ways, kind="stable")[: np.count_nonzero(ways < FAR)]
        who_in = {cell: who for who, cell in enumerate(where)}
        who_in |= {cell: ~who for who, cell in enumerate(people)}
        for chief in np.roll(chiefs, 1 - self._tries)[:MAX_CHIEFS].tolist():
            movers = self._around(where[chief], {*who_in} - walls)
            robots = frozenset(cell for cell in movers if who_in[cell] >= 0)
            persons = tuple(cell for cell in movers if who_in[cell] < 0)
            start = State(where[chief], robots, persons)
            blocked = {*who_in, *walls} - {where[chief], *movers}
            aims = [self._progress[:, ~who_in[cell]].argmax() for cell in persons]
            steps = self._search(start, int(goals[chief]), blocked, self._stations[aims])
            if steps:
                at = {cell: who_in[cell] for cell in (where[chief], *movers)}
                self.held = [who for who in at.values() if who >= 0]
                moves = []
                for begin, end in steps:
                    at[end] = at.pop(begin)
                    moves.append(Move(at[end], begin, end))
                return moves
        return []

    def _around(self, cell: int, others: set[int]) -> list[int]:
        """Return the cells of the others that are nearest to a cell."""
        found, known = [cell], {cell}
        for place in found:
            new = [each for each in self._near[place] if each not in known]
            found += new
            known.update(new)
        return [each for each in found[1:] if each in others][:MAX_OTHERS]

    def _search(
        self, start: State, goal: int, blocked: set[int], aims: Integers
    ) -> list[tuple[int, int]]:
        """Return steps, each from a cell to a free one, that lead the chief to its goal."""
        rows = self._fields.rows(np.append(aims, goal))
        *fields, ways = self._fields.matrix[rows].tolist()
        prices = (PERSON_ON, PERSON_BACK) if self._tries % 2 else (PERSON_BACK, PERSON_ON)
        costs, before = {start: 0}, dict[State, tuple[State, int, int]]()
        heap, count, on_way = [(0, 0, start)], 0, dict[int, set[int]]()
        while heap and count < MAX_STATES:
            state = heappop(heap)[-1]
            if state.chief == goal:
                steps = []
                while state != start:
                    state, begin, end = before[state]
                    steps.append((begin, end))
                return steps[::-1]
            taken = blocked | state.robots | {state.chief, *state.people}
            for begin in (state.chief, *state.robots, *state.people):
                for end in self._near[begin]:
                    if end in taken:
                        continue
                    after, price = state.moved(begin, end), 1
                    if begin in state.people:
                        field = fields[state.people.index(begin)]
                        price = prices[field[end] >= field[begin]]
                    cost = costs[state] + price
                    if cost >= costs.get(after, FAR):
                        continue
                    costs[after], before[after] = cost, (state, begin, end)
                    if after.chief not in on_way:
                        on_way[after.chief] = self._way(after.chief, ways)
                    way, count = on_way[after.chief], count + 1
                    crowd = len(way & after.robots) + len(way.intersection(after.people))
                    estimate = GREED * (ways[after.chief] + IN_THE_WAY * crowd)
                    heappush(heap, (cost + estimate, count, after))
        return []

    def _way(self, cell: int, ways: list[int]) -> set[int]:
        """Return the cells of a shortest way from a cell, without the cell itself."""
        found = set[int]()
        while ways[cell]:
            cell = min(self._near[cell], key=ways.__getitem__)
            found.add(cell)
        return found
