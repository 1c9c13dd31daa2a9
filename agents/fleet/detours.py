"""Robots that do not wait for ever beside a person or a robot that stays: they go around, or back.

A planner does not look for ways around those that stay for some steps, and a robot that waits for
the cell of a person may be the one that the person waits for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.assignment import NONE
from agents.mapf.graph import CLOSED, Graph
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Flags, Integers

PATIENCE = 3
"""Steps for which a robot waits beside one that is in its way."""


class Detours:
    """Gives robots that are held up another goal for some steps.

    A robot is held up if it has waited for ``PATIENCE`` steps beside a person or a robot that
    stays. It goes around both as far as it has to, until a cheapest way to its goal leads on from
    there. If there is no way around, it goes back behind the next junction, and lets a person out.
    So does each robot beside a person that robots enclose.

    Args:
        graph: floor with the costs of moves by which the robots find their ways.
        robots: ``R``.
    """

    def __init__(self, graph: Graph, robots: int) -> None:
        self._open, self._around = graph, Graph(graph.layout, graph.costs)
        self._cells = np.full(robots, NONE)
        self._waits = np.zeros(robots, np.intp)
        self._aims, self._goals = np.full((2, robots), NONE)

    def goals(
        self, cells: Integers, goals: Integers, stays: Flags, people: Integers
    ) -> NDArray[np.intp]:
        """Return the cell that each robot is to go to instead of its goal, ``[R]``, or ``NONE``.

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
        beside = self._open.neighbours[people, :WAIT]
        enclosed = people[has_robot[beside].all(axis=1)]
        encloses = np.isin(near, enclosed).any(axis=1)
        is_held = (cells == self._cells) & ~stays & ((goals != cells) | encloses)
        self._waits = np.where(is_held, self._waits + 1, 0)
        self._aims[(cells == self._aims) | (goals != self._goals) | stays] = NONE
        self._cells, self._goals = cells.copy(), goals.copy()
        held = (self._waits >= PATIENCE) & (is_in_the_way[near].any(axis=1))
        if held.any():
            self._around.close(frozenset(np.flatnonzero(is_in_the_way).tolist()))
            for robot in np.flatnonzero(held).tolist():
                self._aims[robot] = self._aim(int(cells[robot]), int(goals[robot]))
                self._waits[robot] = 0
        return self._aims

    def _aim(self, cell: int, goal: int) -> int:
        """Return where a robot leaves its way around, or gives way."""
        around, straight = self._around, self._open.distances(goal)
        field = around.distances(goal, keep=False).copy()
        field[list(around.closed)] = np.inf
        field[cell] = around.distances(goal, keep=False)[cell]
        if cell == goal or not np.isfinite(field[cell]):
            return self._refuge(cell)
        place = cell
        while straight[place] != field[place]:
            sides = around.neighbours[place, :WAIT]
            costs = 1 if around.costs is None else around.costs[place]
            place = int(sides[np.where(sides == CLOSED, np.inf, field[sides] + costs).argmin()])
        return goal if place == cell else place

    def _refuge(self, cell: int) -> int:
        """Return the nearest cell behind a junction, or the last cell of a dead end."""
        found, known = [cell], {cell}
        for place in found:
            sides = [each for each in self._open.neighbours[place, :WAIT].tolist() if each != CLOSED]
            new = [each for each in sides if each not in known | self._around.closed]
            if len(sides) > 2 and new and place != cell:
                return new[0]
            found += new
            known.update(new)
        return found[-1]
