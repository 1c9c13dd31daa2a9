"""Detours: robots that are blocked by a person or a staying robot go around them, or back.

A planner does not plan around obstacles that stay for only some steps. Also, a robot that waits for
the cell of a person may be the robot for which the person waits.
"""

from __future__ import annotations

import numpy as np

from agents.mapf.assignment import NONE
from agents.mapf.graph import CLOSED, Graph
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Flags, Integers

PATIENCE = 3
"""Waiting time next to an obstacle after which a robot counts as held up, in steps of a cell."""

LONGER = 1e-3
"""Difference of costs above which a path counts as longer; sums of costs are rounded."""


class Detours:
    """Temporary goals for robots that are held up, until they have passed the obstacle.

    A robot is held up if it has waited for the time of ``PATIENCE`` cells next to a person or a
    staying robot. It then goes around all such obstacles, as far as necessary. If nothing blocks
    its own path, it takes priority over others. If no path around exists, it goes back behind the
    nearest junction, so that a person can get out. The robots next to a person whom robots enclose
    do the same.

    Args:
        graph: floor with the costs of moves that the robots' paths use.
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
        """Return the temporary goals that robots have to reach before their goals, by robot.

        Args:
            cells: ``[R]`` cells of the robots.
            goals: ``[R]`` goal cells of the robots.
            stays: ``[R]`` flags of robots that stay for a long time.
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
        """Return the sequence of goals with which a robot goes around obstacles or gives way."""
        field = self._around.distances(goal).copy()
        gives_way = cell == goal or not np.isfinite(field[cell])
        if gives_way:
            goal = self._refuge(cell)
            field = self._around.distances(goal).copy()
        straight, path = self._open.distances(goal), [cell]
        field[[each for each in self._around.closed if each != cell]] = np.inf
        while field[path[-1]] - straight[path[-1]] > LONGER:
            sides = self._open.neighbours[path[-1], :WAIT]
            costs = 1 if self._open.costs is None else self._open.costs[path[-1]]
            best = np.where(sides == CLOSED, np.inf, field[sides] + costs).argmin()
            path.append(int(sides[best]))
        legs, first = [], 0
        while first < len(path) - 1:
            last, costs = len(path) - 1, field[path[first]] - field[path]
            while last > first + 1 and (
                self._open.distances(path[last])[path[first]] < costs[last] - LONGER
            ):
                last = (first + last) // 2
            legs.append(path[last])
            first = last
        return [*legs, goal] if gives_way else legs or [goal]

    def _refuge(self, cell: int) -> int:
        """Return the nearest cell behind a junction, or the last cell of a dead end."""
        reached, known = [cell], {cell, CLOSED, *self._around.closed}
        for place in reached:
            sides: list[int] = self._open.neighbours[place, :WAIT].tolist()
            new = [each for each in sides if each not in known]
            if new and place != cell and len(sides) - sides.count(CLOSED) > 2:
                return new[0]
            reached += new
            known.update(new)
        return reached[-1]
