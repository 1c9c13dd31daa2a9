"""Problems of multi-agent path finding, and the plans that solve them.

``R`` is the number of robots and ``T`` the number of joint steps. In a joint step, every robot
moves to a neighbour of its cell or waits. A robot with a heading moves to the cell ahead, turns by
a quarter in its cell, or waits. Two robots must not be in one cell, nor swap cells. A robot may
follow another one into the cell that it leaves, and three or more robots may rotate in a ring.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import Fields, Graph, HeadedFields
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

__all__ = ["Plan", "Problem"]


@dataclass(frozen=True, eq=False)
class Problem:
    """Robots that have to move from ``[R]`` starts to ``[R]`` goals and stay there.

    Args:
        graph: floor.
        starts: ``[R]``, initial cells of the robots.
        goals: ``[R]``, goal cells, in which the robots may have any heading.
        headings: ``[R]``, initial headings, 0 to 3 for N, E, S and W, of robots that drive forward
            and turn on the spot. ``None`` is for robots that move in four directions.

    Raises:
        PlanError: turns have a cost in the graph, or ``headings`` is not one number from 0 to 3 for
            each robot. Or it is certain that no plan exists: a start or a goal is not an open cell,
            two robots have the same one, or a goal is unreachable. The message says which.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> problem.robots, problem.lower_bound
        (2, 4)
        >>> problem = Problem(problem.graph, problem.starts, problem.goals, headings=[1, 1])
        >>> problem.lower_bound  # the second robot turns round first
        6
    """

    graph: Graph
    starts: Sequence[int]
    goals: Sequence[int]
    headings: Sequence[int] | None = None

    def __post_init__(self) -> None:
        if self.graph.turn_cost:
            raise PlanError(
                f"turn_cost of the graph is {self.graph.turn_cost!r}; in a problem it must be 0"
            )
        if len(self.starts) != len(self.goals):
            raise PlanError(
                f"{len(self.starts)} starts and {len(self.goals)} goals; each robot needs both"
            )
        self._check_headings()
        self._check("start", self.starts)
        self._check("goal", self.goals)
        parts = self.graph.parts
        for robot, (start, goal) in enumerate(zip(self.starts, self.goals, strict=True)):
            if parts[start] != parts[goal]:
                raise PlanError(
                    f"robot {robot}: no path exists from {self._cell(start)} to {self._cell(goal)}"
                )

    @property
    def robots(self) -> int:
        """The number of robots, ``R``."""
        return len(self.starts)

    @cached_property
    def fewest_steps(self) -> Integers:
        """``[R]``, the length of the shortest path from each start to its goal, in steps."""
        fields = self.fields(self.graph.with_costs())
        return fields.distances(np.array(self.goals, np.intp), self.places)

    @property
    def lower_bound(self) -> int:
        """Sum of the shortest path lengths, below the sum of costs of every plan."""
        return int(self.fewest_steps.sum())

    @property
    def places(self) -> Integers:
        """``[R]``, initial places of the robots; see ``places_of``."""
        headings = None if self.headings is None else np.array(self.headings, np.intp)
        return places_of(self.graph, np.array(self.starts, np.intp), headings)

    def fields(self, graph: Graph) -> Fields:
        """Return the distance fields of these robots on a graph."""
        return Fields(graph) if self.headings is None else HeadedFields(graph)

    def plan_of(self, places: Integers, bound: int | None = None) -> Plan:
        """Return the plan with the given ``[T + 1, R]`` places and bound."""
        headings, cells = np.divmod(places, self.graph.size)
        return Plan(cells, bound, None if self.headings is None else headings)

    def refuse_headings(self, solver: str) -> None:
        """Raise ``PlanError`` if robots have headings, which a solver does not support."""
        if self.headings is not None:
            raise PlanError(f"{solver} does not support headings, which the robots have")

    def _check_headings(self) -> None:
        if self.headings is None:
            return
        if len(self.headings) != self.robots:
            raise PlanError(
                f"{len(self.headings)} headings; each of {self.robots} robots needs one"
            )
        for robot, heading in enumerate(self.headings):
            if heading not in range(len(HEADINGS)):
                raise PlanError(f"robot {robot}: its heading is {heading!r}; allowed: 0..3")

    def _check(self, name: str, cells: Sequence[int]) -> None:
        layout, first = self.graph.layout, dict[int, int]()
        for robot, cell in enumerate(cells):
            if not 0 <= cell < self.graph.size or not layout.is_open(self._cell(cell)):
                raise PlanError(f"robot {robot}: its {name} {self._cell(cell)} is not an open cell")
            if first.setdefault(cell, robot) != robot:
                raise PlanError(
                    f"robots {first[cell]} and {robot} have the same {name} {self._cell(cell)}"
                )

    def _cell(self, cell: int) -> tuple[int, int]:
        return self.graph.layout.cell(cell)


@dataclass(frozen=True, eq=False)
class Plan:
    """Cells of the robots before each joint step and after the last, ``[T + 1, R]``.

    ``headings`` has the headings of the robots at the same times, ``[T + 1, R]``, or is ``None`` if
    robots move in four directions. ``bound`` is a lower bound on the sum of costs of all plans that
    the solver has proved, or ``None``. For a plan that is proved to be optimal, it equals the sum
    of costs.

    Example:
        >>> from agents.mapf.problem import Plan
        >>> plan = Plan.of([[0, 1, 2], [5, 5]])
        >>> plan.makespan, plan.sum_of_costs
        (2, 2)
    """

    cells: Integers
    bound: int | None = None
    headings: Integers | None = None

    @classmethod
    def of(cls, paths: Sequence[Sequence[int]], bound: int | None = None) -> Plan:
        """Return the plan with these paths of any length; each robot stays in its last cell."""
        steps = max(map(len, paths), default=1)
        cells = [[*path, *[path[-1]] * (steps - len(path))] for path in paths]
        return cls(np.array(cells, np.int64).reshape(len(paths), steps).T, bound)

    def places(self, graph: Graph) -> Integers:
        """Return the places of the robots on a graph, ``[T + 1, R]``; see ``places_of``."""
        return places_of(graph, self.cells, self.headings)

    @property
    def makespan(self) -> int:
        """The number of joint steps, ``T``."""
        return len(self.cells) - 1

    @property
    def costs(self) -> Integers:
        """``[R]``, the number of steps until each robot is in its last cell for good."""
        is_there = (self.cells == self.cells[-1])[::-1]
        stays = np.where(is_there.all(axis=0), len(is_there), is_there.argmin(axis=0))
        return len(is_there) - stays

    @property
    def sum_of_costs(self) -> int:
        """The sum of ``costs``, which optimal planners minimize."""
        return int(self.costs.sum())


def places_of(graph: Graph, cells: Integers, headings: Integers | None) -> Integers:
    """Return the places of robots: their cells, plus ``H * W`` times their headings if any."""
    return cells if headings is None or not len(headings) else headings * graph.size + cells


Solver = Callable[[Problem, float], Plan]
"""Function that returns a plan for a problem within a time limit in seconds by the clock.

It raises ``PlanError`` if no plan exists, or if it found none in time.
"""
