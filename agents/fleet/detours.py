"""Robots that do not wait for ever beside a person or a robot that stays: they go around, or back.

A planner does not look for ways around those that stay for some steps, and a robot that waits for
the cell of a person may be the one that the person waits for.
"""

from __future__ import annotations

import numpy as np

from agents.mapf.assignment import NONE
from agents.mapf.graph import CLOSED, Graph
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Flags, Integers

PATIENCE = 3
"""Steps of a cell for which a robot waits beside one that is in its way."""

LONGER = 1e-3
"""Difference of costs from which one way is longer than another; sums of costs are rounded."""


class Detours:
    """Gives robots that are held up other goals until they are past what holds them up.

    A robot is held up if it has waited for ``PATIENCE`` cells' time beside a person or a robot that
    stays. It goes around all of these, as far as it has to; if nothing is in its own way, it
    goes before others. If there is no way around, it goes back behind the next junction, and so
    lets a person out. So does each robot beside a person whom robots enclose.

    Args:
        graph: floor with the costs of moves by which the robots find their ways.
        robots: ``R``.
        cell_steps: steps in which a robot crosses a cell.
    """

    def __init__(self, graph: Graph, robots: int, cell_steps: float = 1.0) -> None:
        self._patience = PATIENCE * cell_steps
        self._open, self._around = (Graph(graph.layout, graph.costs) for _ in range(2))
        self._cells, self._goals = np.full((2, robots), NONE)
        self._waits = np.zeros(robots, np.intp)
        self._legs: dict[int, list[int]] = {}

    def goals(
        self, cells: Integers, goals: Integers, stays: Flags, people: Integers
    ) -> dict[int, int]:
        """Return where robots are to go before they go to their goals, by robot.

        Args:
            cells: ``[R]`` cells of the robots.
            goals: ``[R]`` cells where the robots are to go.
            stays: ``[R]`` flags of robots that stay for long.
            people: cells of people.
        """
        near = self._open.neighbours[cells, :WAIT]
        is_in_the_way, has_robot = np.zeros((2, self._open.size + 1), np.bool_)
        is_in_the_way[people] = is_in_the_way[cells[stays]] = True
        has_robot[cells] = has_robot[CLOSED] = True
        enclosed = people[has_robot[self._open.neighbours[people, :WAIT]].all(axis=1)]
        is_held = (cells == self._cells) & ~stays & ~np.isin(goals, cells[stays])
        is_held &= (goals != cells) | np.isin(near, enclosed).any(axis=1)
        self._waits = np.where(is_held, self._waits + 1, 0)
        is_changed = stays | (goals != self._goals)
        self._cells, self._goals = cells.copy(), goals.copy()
        stands = self._waits >= self._patience
        self._waits[stands] = 0
        for robot, legs in list(self._legs.items()):
            if legs[0] == cells[robot]:
                legs.pop(0)
            if not legs or is_changed[robot] or stands[robot]:
                del self._legs[robot]
        held = np.flatnonzero(stands & is_in_the_way[near].any(axis=1))
        if len(held):
            self._around.close(frozenset(np.flatnonzero(is_in_the_way).tolist()))
        for robot in held.tolist():
            self._legs[robot] = self._legs_of(int(cells[robot]), int(goals[robot]))
        return {robot: legs[0] for robot, legs in self._legs.items()}

    def _legs_of(self, cell: int, goal: int) -> list[int]:
        """Return where a robot goes one after the other to go around, or to give way."""
        field = self._around.distances(goal, keep=False)
        gives_way = cell == goal or not np.isfinite(field[cell])
        if gives_way:
            goal = self._refuge(cell)
            field = self._around.distances(goal, keep=False)
        straight, way = self._open.distances(goal), [cell]
        field[[each for each in self._around.closed if each != cell]] = np.inf
        while field[way[-1]] - straight[way[-1]] > LONGER:
            sides = self._open.neighbours[way[-1], :WAIT]
            costs = 1 if self._open.costs is None else self._open.costs[way[-1]]
            best = np.where(sides == CLOSED, np.inf, field[sides] + costs).argmin()
            way.append(int(sides[best]))
        legs, first = [], 0
        while first < len(way) - 1:
            last, costs = len(way) - 1, field[way[first]] - field[way]
            while last > first + 1 and (
                self._open.distances(way[last])[way[first]] < costs[last] - LONGER
            ):
                last = (first + last) // 2
            legs.append(way[last])
            first = last
        return [*legs, goal] if gives_way else legs or [goal]

    def _refuge(self, cell: int) -> int:
        """Return the nearest cell behind a junction, or the last cell of a dead end."""
        found, known = [cell], {cell, CLOSED, *self._around.closed}
        for place in found:
            sides: list[int] = self._open.neighbours[place, :WAIT].tolist()
            new = [each for each in sides if each not in known]
            if new and place != cell and len(sides) - sides.count(CLOSED) > 2:
                return new[0]
            found += new
            known.update(new)
        return found[-1]
