"""A problem of several robots, and the plans that solve it.

``R`` is the number of robots and ``T`` the number of joint steps. In a joint step every robot moves
to a neighbour of its cell or waits. Robots with headings move to the cell that they head for, turn
by a quarter in their cell, or wait. No two robots may be in one cell, nor change places; following
is allowed, and so are rings, in which three or more robots move into one another's cells.

Example:
    >>> from agents.mapf.lacam import lacam
    >>> from agents.mapf.problem import Solver
    >>> solve: Solver = lacam
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import Fields, Graph
from agents.mapf.headed import HeadedFields
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

__all__ = ["Plan", "Problem", "Solver"]


@dataclass(frozen=True, eq=False)
class Problem:
    """Robots that are to go from ``[R]`` starts to ``[R]`` goals, and to stay there.

    Args:
        graph: floor.
        starts: ``[R]``, cells of the robots at first.
        goals: ``[R]``, cells to go to; there robots may head anywhere.
        headings: ``[R]``, where robots head at first, 0 to 3 for N, E, S and W: they drive forward
            and turn on the spot then. ``None`` is for robots that move in four directions.

    Raises:
        PlanError: turns have a cost in the graph, or ``headings`` are no number 0 to 3 for each
            robot. Or no plan can exist, as can be seen at once: a start or a goal is no open cell,
            two robots have the same, or no way leads from a start to its goal; the message says
            which.

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
                f"turn_cost is {self.graph.turn_cost!r}; in a problem turns cost nothing"
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
                    f"robot {robot}: no way leads from {self._cell(start)} to {self._cell(goal)}"
                )

    @property
    def robots(self) -> int:
        """``R``."""
        return len(self.starts)

    @cached_property
    def fewest_steps(self) -> Integers:
        """``[R]``, the fewest steps from each start to its goal."""
        fields = self.fields(self.graph.with_costs())
        return fields.distances(np.array(self.goals, np.intp), self.places)

    @property
    def lower_bound(self) -> int:
        """The sum of the fewest steps from starts to goals; no plan has a lower sum of costs."""
        return int(self.fewest_steps.sum())

    @property
    def places(self) -> Integers:
        """``[R]``, places of the robots at first; see ``places_of``."""
        headings = None if self.headings is None else np.array(self.headings, np.intp)
        return places_of(self.graph, np.array(self.starts, np.intp), headings)

    def fields(self, graph: Graph) -> Fields:
        """Return distances of these robots on a graph."""
        return Fields(graph) if self.headings is None else HeadedFields(graph)

    def plan_of(self, places: Integers, bound: int | None = None) -> Plan:
        """Return the plan of which ``[T + 1, R]`` places and the bound are given."""
        headings, cells = np.divmod(places, self.graph.size)
        return Plan(cells, bound, None if self.headings is None else headings)

    def refuse_headings(self, solver: str) -> None:
        """Raise ``PlanError`` if robots have headings, which a solver does not know."""
        if self.headings is not None:
            raise PlanError(f"{solver} does not know headings, which the robots have")

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
                raise PlanError(f"robot {robot}: its {name} {self._cell(cell)} is no open cell")
            if first.setdefault(cell, robot) != robot:
                raise PlanError(
                    f"robots {first[cell]} and {robot} have the same {name} {self._cell(cell)}"
                )

    def _cell(self, cell: int) -> tuple[int, int]:
        return self.graph.layout.cell(cell)


@dataclass(frozen=True, eq=False)
class Plan:
    """Cells of the robots before each joint step and after the last, ``[T + 1, R]``.

    ``headings`` has the headings of the robots at the same times, ``[T + 1, R]``; it is ``None``
    where robots move in four directions. ``bound`` is the lower bound on the sum of costs of all
    plans that the solver has proved, or ``None`` if it has proved none; an optimal plan has its own
    cost there.

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
    def of(cls, ways: Sequence[Sequence[int]], bound: int | None = None) -> Plan:
        """Return the plan of ways of any lengths; each robot stays in its last cell."""
        steps = max(map(len, ways), default=1)
        cells = [[*way, *[way[-1]] * (steps - len(way))] for way in ways]
        return cls(np.array(cells, np.int64).reshape(len(ways), steps).T, bound)

    def places(self, graph: Graph) -> Integers:
        """Return the places of the robots on a graph, ``[T + 1, R]``; see ``places_of``."""
        return places_of(graph, self.cells, self.headings)

    @property
    def makespan(self) -> int:
        """``T``, the number of joint steps."""
        return len(self.cells) - 1

    @property
    def costs(self) -> Integers:
        """``[R]``, the steps until each robot is in its last cell for good."""
        is_there = (self.cells == self.cells[-1])[::-1]
        stays = np.where(is_there.all(axis=0), len(is_there), is_there.argmin(axis=0))
        return len(is_there) - stays

    @property
    def sum_of_costs(self) -> int:
        """The sum of ``costs``, which optimal planners make as small as can be."""
        return int(self.costs.sum())


def places_of(graph: Graph, cells: Integers, headings: Integers | None) -> Integers:
    """Return the places of robots: their cells, plus ``H * W`` times their headings if any."""
    return cells if headings is None else headings * graph.size + cells


Solver = Callable[[Problem, float], Plan]
"""Function that returns a plan for a problem within so many seconds by the clock.

It raises ``PlanError`` if there is no plan, or if it found none in time.
"""
