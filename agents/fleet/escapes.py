"""Escapes from deadlocks: planned moves of some robots, one after another, for a stuck fleet.

In a narrow place, robots may wait forever for one another, or for people who wait for them. A
search over the cells of the robots and people around one robot finds moves that bring it to its
goal.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from agents.mapf.assignment import NONE
from agents.mapf.graph import CLOSED, Fields
from agents.mapf.kernels.places import FAR
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

PATIENCE = 6
"""Time without progress of any robot after which a fleet counts as stuck, in steps of a cell."""

STANDS = 4
"""Time without any move after which moves are planned again, in steps of a cell."""

MAX_OTHERS, MAX_STATES, MAX_CHIEFS = 10, 10_000, 2
"""Limits of a plan: other robots and people that move, expanded states, and robots to be freed."""

STEP_STATES = 1_000
"""Expanded states in a step, which take up to 0.1 s. The search then goes on in the next step."""

PERSON_ON, PERSON_BACK = 2, 6
"""Costs of a person's step towards a station and of a step back, in moves of a robot.

They are exchanged in every other attempt, because people may intend something else.
"""

MEMORY = 0.8
"""Factor by which the weight of a person's past progress decreases with each step."""

IN_THE_WAY = 3
"""Estimated number of moves to clear each robot or person from the path of a robot."""

GREED = 2
"""Weight of the remaining steps to the goal relative to the cost so far."""


class State(NamedTuple):
    """Cells of the robot that has to reach its goal (the chief), of other robots, and of people."""

    chief: int
    robots: frozenset[int]
    people: tuple[int, ...]

    def moved(self, start: int, end: int) -> State:
        """Return the state after a robot or a person has moved from one cell to another."""
        if start == self.chief:
            return self._replace(chief=end)
        if start in self.robots:
            return self._replace(robots=self.robots - {start} | {end})
        return self._replace(people=tuple(end if at == start else at for at in self.people))


class Move(NamedTuple):
    """A step of a robot, given by its number, or of a person, whose number is negative."""

    who: int
    start: int
    end: int


class Escapes:
    """Plans for the robots of a stuck fleet, and their execution move by move.

    A fleet is stuck if no robot comes closer to its goal than its smallest distance since a robot
    last picked, dropped or charged. A search then plans moves, one at a time, that bring one robot
    to its goal. People in the plan walk to stations, or back; robots wait until they do so.

    Args:
        fields: distances on the floor, in steps.
        robots: ``R``.
        cell_steps: steps in which a robot crosses a cell.

    Attributes:
        held: robots that make only planned moves.
    """

    def __init__(self, fields: Fields, robots: int, cell_steps: float = 1.0) -> None:
        self._patience, self._most_stands = PATIENCE * cell_steps, STANDS * cell_steps
        graph = fields.graph
        sides: list[list[int]] = graph.neighbours[:, :WAIT].tolist()
        self._fields = fields
        self._near = [[each for each in neighbours if each != CLOSED] for neighbours in sides]
        layout = graph.layout
        stations = [*layout.pickups, *layout.dropoffs, *layout.chargers]
        self._stations = layout.numbers(stations)
        self._people: Integers = np.empty(0, np.intp)
        self._progress = np.zeros((len(self._stations), 0))
        self._nearest = np.full(robots, FAR)
        self._cells = np.full(robots, NONE)
        self._waits = self._stands = self._tries = 0
        self._moves: list[Move] = []
        self._going: Iterator[list[Move]] | None = None
        self._at: dict[int, int] = {}
        self.held: list[int] = []

    def aims(
        self, cells: Integers, goals: Integers, distances: Integers, walls: set[int],
        people: Integers, has_worked: bool,
    ) -> dict[int, int]:  # fmt: skip
        """Return the cells that robots must have after this step, by robot; others move freely.

        Args:
            cells: ``[R]`` cells of the robots.
            goals: ``[R]`` goal cells of the robots.
            distances: ``[R]`` distances to the goals in steps, ``FAR`` for robots without a task.
            walls: cells of robots that stay for a long time, and other closed cells.
            people: cells of people.
            has_worked: true if a robot picks, drops, or begins or ends to charge.
        """
        self._watch(people)
        if has_worked:
            self._nearest[:] = FAR
            self._tries = 0
        is_nearer = distances < self._nearest
        self._nearest[is_nearer] = distances[is_nearer]
        self._waits = 0 if has_worked or is_nearer.any() else self._waits + 1
        self._stands = self._stands + 1 if np.array_equal(cells, self._cells) else 0
        self._cells = cells.copy()
        where, persons = cells.tolist(), people.tolist()
        is_stuck = (
            self._stands >= self._most_stands if self._moves else self._waits >= self._patience
        )
        if is_stuck and self._going is None:
            self._waits = self._stands = 0
            self._tries += 1
            self._moves, self._at = [], {}
            self._going = self._plan(where, goals, distances, walls, persons)
        if self._going is not None:
            self._moves = self._continue(where, persons)
        while self._moves and self._is_made(self._moves[0], where, persons):
            self._moves.pop(0)
        if not self._moves and self._going is None:
            self.held = []
        positions, taken = {robot: where[robot] for robot in self.held}, {*where, *persons, *walls}
        for who, start, end in self._moves:
            if who < 0 or positions[who] != start or where[who] != start or end in taken:
                break
            positions[who] = end
            taken = taken - {start} | {end}
        return positions

    def _continue(self, where: list[int], people: list[int]) -> list[Move]:
        """Return the moves that the search finds in this step, or none.

        The search ends if a robot or a person that it plans for has moved.
        """
        assert self._going is not None
        stands = all((where[w] if w >= 0 else people[~w]) == cell for cell, w in self._at.items())
        found = next(self._going, None) if stands else None
        if found or found is None:
            self._going = None
        return found or []

    def _is_made(self, move: Move, where: list[int], people: list[int]) -> bool:
        return where[move.who] == move.end if move.who >= 0 else people[~move.who] != move.start

    def _watch(self, people: Integers) -> None:
        """Estimate the stations to which people walk."""
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
        self,
        where: list[int],
        goals: Integers,
        distances: Integers,
        walls: set[int],
        people: list[int],
    ) -> Iterator[list[Move]]:
        """Yield moves that bring one of the robots nearest to their goals to its goal.

        While the search goes on, it yields no moves after each ``STEP_STATES`` states.
        """
        chiefs = np.argsort(distances, kind="stable")[: np.count_nonzero(distances < FAR)]
        who_in = {cell: who for who, cell in enumerate(where)}
        who_in |= {cell: ~who for who, cell in enumerate(people)}
        for chief in np.roll(chiefs, 1 - self._tries)[:MAX_CHIEFS].tolist():
            movers = self._around(where[chief], {*who_in} - walls)
            robots = frozenset(cell for cell in movers if who_in[cell] >= 0)
            persons = tuple(cell for cell in movers if who_in[cell] < 0)
            start = State(where[chief], robots, persons)
            blocked = {*who_in, *walls} - {where[chief], *movers}
            aims = [self._progress[:, ~who_in[cell]].argmax() for cell in persons]
            self._at = {cell: who_in[cell] for cell in (where[chief], *movers)}
            self.held = [who for who in self._at.values() if who >= 0]
            search = self._search(start, int(goals[chief]), blocked, self._stations[aims])
            for steps in search:
                at, moves = self._at.copy(), []
                for begin, end in steps:
                    at[end] = at.pop(begin)
                    moves.append(Move(at[end], begin, end))
                yield moves

    def _around(self, cell: int, others: set[int]) -> list[int]:
        """Return the occupied cells that are nearest to a cell."""
        reached, known = [cell], {cell}
        for place in reached:
            new = [each for each in self._near[place] if each not in known]
            reached += new
            known.update(new)
        return [each for each in reached[1:] if each in others][:MAX_OTHERS]

    def _search(
        self, start: State, goal: int, blocked: set[int], aims: Integers
    ) -> Iterator[list[tuple[int, int]]]:
        """Yield steps, each from a cell to a free one, that bring the chief to its goal.

        While the search goes on, it yields no steps after each ``STEP_STATES`` states.
        """
        rows = self._fields.rows(np.append(aims, goal))
        *fields, distances = self._fields.matrix[rows].tolist()
        prices = (PERSON_ON, PERSON_BACK) if self._tries % 2 else (PERSON_BACK, PERSON_ON)
        costs, before = {start: 0}, dict[State, tuple[State, int, int]]()
        heap, count, paths = [(0, 0, start)], 0, dict[int, set[int]]()
        while heap and count < MAX_STATES:
            state = heappop(heap)[-1]
            if state.chief == goal:
                steps = []
                while state != start:
                    state, begin, end = before[state]
                    steps.append((begin, end))
                yield steps[::-1]
                return
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
                    if after.chief not in paths:
                        paths[after.chief] = self._path(after.chief, distances)
                    path, count = paths[after.chief], count + 1
                    crowd = len(path & after.robots) + len(path.intersection(after.people))
                    estimate = GREED * (distances[after.chief] + IN_THE_WAY * crowd)
                    heappush(heap, (cost + estimate, count, after))
                    if count % STEP_STATES == 0:
                        yield []

    def _path(self, cell: int, distances: list[int]) -> set[int]:
        """Return the cells of a shortest path from a cell, without the cell itself."""
        reached = set[int]()
        while distances[cell]:
            cell = min(self._near[cell], key=distances.__getitem__)
            reached.add(cell)
        return reached
