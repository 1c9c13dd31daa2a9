"""Planners for robots whose goals change: they choose the next cell of each robot, step by step."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from agents.errors import PlanError
from agents.mapf.graph import CLOSED, EAST, Fields, Graph, robots_in
from agents.mapf.kernels.places import NONE
from agents.mapf.problem import Plan, Problem
from agents.mapf.waypoints import Waypoints
from warehouse_core.wording import brief, counted
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

__all__ = ["Planner", "Situation"]

SIDES = ("north", "east", "south", "west")
"""Names of the headings."""

NO_CELLS = np.empty(0, np.intp)


class Situation(NamedTuple):
    """What a planner knows of ``R`` robots before a joint step; cells are numbers.

    Attributes:
        cells: ``[R]``, cells of the robots, all different.
        goals: ``[R]``, goal cells; several robots may have the same goal. A robot without a task
            has its own cell as its goal, and gives way.
        stays: ``[R]``, true for robots that cannot move in this step, because they pick, drop or
            charge, or have a flat battery.
        closed: cells that no robot can enter in this step, such as cells of people.
        urgent: robots that should go before all others, such as robots that go around an obstacle.
        undelayed: robots among them that should not be late, such as robots with a low battery.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.pibt import PIBT
        >>> from agents.mapf.planner import Situation
        >>> from warehouse_core import Layout
        >>> cells, goals, none = np.array([0, 2]), np.array([2, 0]), np.array([], int)
        >>> situation = Situation(cells, goals, stays=np.array([False, False]), closed=none)
        >>> PIBT(Graph(Layout(["...", "..."]))).next_cells(situation)
        array([1, 2])
    """

    cells: Integers
    goals: Integers
    stays: NDArray[np.bool_]
    closed: Integers
    urgent: Integers = NO_CELLS
    undelayed: Integers = NO_CELLS


@runtime_checkable
class Planner(Protocol):
    """Interface of planners that choose the next cells of robots on one ``Graph``.

    A class needs only these two methods. It may also have:

        - ``next_places(situation, headings)``, for robots with headings; see ``PlacePlanner``,
        - ``graph``, whose costs the robots follow, and in which cells can be closed,
        - ``plan_of(robot)``, the cells of a robot after each of the next steps, starting with the
          cell just chosen,
        - ``pushers``, ``[R]``, the robot that made each robot choose before its turn in the last
          step, or ``NOBODY``.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.pibt import PIBT
        >>> from agents.mapf.planner import Planner
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> planner: Planner = PIBT(Graph(DEFAULT_LAYOUT))
        >>> isinstance(planner, Planner)
        True
    """

    def reset(self) -> None:
        """Forget the last episode."""

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step, ``[R]``.

        The step must have no conflict: no two robots may be in one cell or swap cells, and no robot
        may enter a closed cell. Each cell is the robot's own cell or a neighbour of it.
        """


def knows_headings(planner: Planner) -> bool:
    """Return whether a planner plans for robots that drive forward and turn on the spot."""
    return getattr(planner, "knows_headings", hasattr(planner, "next_places"))


def next_steps(planner: Planner, situation: Situation, headings: Integers) -> Integers:
    """Return the choice of a planner: places for robots with headings, otherwise cells."""
    if len(headings):
        return cast(PlacePlanner, planner).next_places(situation, headings)
    return planner.next_cells(situation)


class PlacePlanner(ABC):
    """Base class of planners that choose places, with or without headings.

    A subclass prepares an episode in ``_begin`` and chooses places in ``_choose``.

    Attributes:
        graph: graph whose costs the robots follow.
        fields: distances to the goals of the robots, at the latest after ``_begin``.
        knows_headings: true if ``next_places`` plans for robots that drive forward and turn.
    """

    graph: Graph
    fields: Fields
    knows_headings = True

    def reset(self) -> None:
        """Forget the last episode, and restart the random numbers from the seed."""
        self._begun_for = 0, False

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step, ``[R]``."""
        return self._next(situation, None) % self.graph.size

    def next_places(self, situation: Situation, headings: Integers) -> Integers:
        """Return the place of each robot after the next joint step, ``[R]``.

        A place is ``heading * H * W + cell``. A robot moves to the cell ahead, or it keeps its cell
        and turns by at most a quarter. The cells satisfy the same conditions as in ``next_cells``.
        The headings, ``[R]``, are 0 to 3 for N, E, S and W.
        """
        return self._next(situation, headings * self.graph.size + situation.cells)

    def _next(self, situation: Situation, places: Integers | None) -> Integers:
        """Return the next place of each robot; ``places`` are given for robots with headings."""
        if not len(situation.cells):
            return situation.cells
        episode = len(situation.cells), places is not None
        if episode != self._begun_for:
            self._begin(*episode)
            self._begun_for = episode
            self._waypoints = Waypoints(self.fields, len(situation.cells))
        goals = self._waypoints.toward(situation.goals, situation.cells)
        return self._choose(situation._replace(goals=goals), places)

    @abstractmethod
    def _begin(self, robots: int, has_headings: bool) -> None:
        """Begin an episode of the given number of robots."""

    @abstractmethod
    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        """Return the next place of each robot; ``places`` are given for robots with headings."""


class Memory:
    """The headings and ages of ``R`` robots, which a planner remembers from one step to the next.

    An age is the number of steps since the last goal.

    Args:
        graph: floor.
        ranks: ``[R]`` different numbers from 0 to 1, which order robots of equal age.

    Attributes:
        goals: ``[R]``, the goals in the previous step.
        ages: ``[R]``, the ages of the robots in that step.
    """

    def __init__(self, graph: Graph, ranks: NDArray[np.float64]) -> None:
        self._graph, self._ranks, robots = graph, ranks, len(ranks)
        self.goals, self.ages = np.full(robots, NONE), np.zeros(robots, np.intp)
        self._cells, self._headings = np.full(robots, NONE), np.full(robots, EAST)

    def places(self, cells: Integers) -> Integers:
        """Return the places of the robots, which face where they last moved, and east at first."""
        if not self._graph.turn_cost:
            return cells
        before = np.where(self._cells == NONE, cells, self._cells)
        self._headings = self._graph.headings(before, cells, self._headings)
        self._cells = cells.copy()
        return self._headings * self._graph.size + cells

    def order(self, cells: Integers, goals: Integers, urgent: Integers) -> Integers:
        """Return the robots by decreasing priority: urgent robots first, then the oldest."""
        is_there = (cells == goals) | (cells == self.goals)
        self.ages, self.goals = np.where(is_there, 0, self.ages + 1), goals.copy()
        priorities = self.ages + self._ranks
        priorities[urgent] += self.ages.max(initial=0) + 1
        return np.argsort(-priorities, kind="stable")


def solve_by_steps(planner: Planner, problem: Problem, seconds: float) -> Plan:
    """Return the plan that results when a planner moves all robots until all are at their goals.

    Raises:
        PlanError: this did not happen within the time limit by the clock, although a plan may
            exist. Or the robots have headings, which the planner does not support.
    """
    deadline, size = time.perf_counter() + seconds, problem.graph.size
    places, goals = problem.places, np.array(problem.goals)
    nobody, steps = np.zeros(len(places), np.bool_), [places]
    if not knows_headings(planner):
        problem.refuse_headings(f"planner {type(planner).__name__}")
    planner.reset()
    while (places % size != goals).any():
        if time.perf_counter() > deadline:
            raise PlanError(f"no plan after {seconds:g} s and {counted(len(steps) - 1, 'step')}")
        headings, cells = np.divmod(places, size)
        situation = Situation(cells, goals, nobody, NO_CELLS)
        places = next_steps(planner, situation, NO_CELLS if problem.headings is None else headings)
        steps.append(places)
    return problem.plan_of(np.array(steps))


def check_next(graph: Graph, situation: Situation, headings: Integers, chosen: object) -> Integers:
    """Return the checked choice of a planner: places for robots with headings, otherwise cells."""
    if len(headings):
        return check_turns(graph, situation, headings, chosen)
    return check_step(graph, situation, chosen)


def check_step(graph: Graph, situation: Situation, chosen: object) -> Integers:
    """Return the next cells that a planner has chosen in a situation, after checking them.

    Robots that share a cell, as bodies may after a disturbance, stay there.

    Raises:
        PlanError: the result is not a cell for each robot. Or a robot jumps, moves although it must
            stay, enters a closed cell, or collides with another robot. The message names robots and
            cells.
    """
    cells, stays = situation.cells, situation.stays
    checked = _numbers(chosen, cells, "a cell number")

    def place(cell: np.integer) -> str:
        return str(graph.layout.cell(cell))

    is_near = (graph.neighbours[cells] == checked[:, None]).any(axis=1) & (checked != CLOSED)
    moves = checked != cells
    for is_wrong, why in (
        (~is_near, "which is not an open cell next to it"),
        (moves & stays, "but it has to stay in this step"),
    ):
        for robot in np.flatnonzero(is_wrong)[:1]:
            move = f"from {place(cells[robot])} to {place(checked[robot])}"
            raise PlanError(f"robot {robot} is to go {move}, {why}")
    is_closed = np.zeros(graph.size, np.bool_)
    is_closed[situation.closed] = True
    for robot in np.flatnonzero(moves & is_closed[checked])[:1]:
        raise PlanError(f"robot {robot} is to enter {place(checked[robot])}, which is closed")
    by_cell = np.argsort(checked, kind="stable")
    first, second = by_cell[:-1], by_cell[1:]
    meets = (checked[first] == checked[second]) & (moves[first] | moves[second])
    for one, other in zip(first[meets][:1], second[meets][:1], strict=True):
        raise PlanError(f"robots {one} and {other} are both to be in {place(checked[one])}")
    robot_in = robots_in(graph.size, cells)
    other_in = robot_in[checked]
    swaps = moves & (other_in >= 0) & (checked[other_in] == cells)
    for one in np.flatnonzero(swaps)[:1]:
        raise PlanError(
            f"robots {one} and {other_in[one]} are to change places, {place(cells[one])} and "
            f"{place(checked[one])}"
        )
    return checked


def _numbers(chosen: object, cells: Integers, what: str) -> Integers:
    """Return what a planner has chosen as numbers, one for each robot, or raise ``PlanError``."""
    numbers = np.asarray(chosen)
    if numbers.shape != cells.shape or numbers.dtype.kind not in "iu":
        needed = f"{what} for each of {len(cells)} robots"
        raise PlanError(f"the planner returned {brief(chosen)}; needed: {needed}")
    return numbers


def check_turns(graph: Graph, situation: Situation, headings: Integers, chosen: object) -> Integers:
    """Return the next places that a planner has chosen for robots with headings, once checked.

    Raises:
        PlanError: as for ``check_step``. Or a robot moves in a direction that it does not face,
            turns by more than a quarter, or turns although it must stay. The message names it.
    """
    cells = situation.cells
    checked = _numbers(chosen, cells, "a place")
    turned, to = np.divmod(checked, graph.size)
    is_place = (checked >= 0) & (turned < len(HEADINGS))
    ahead = graph.neighbours[cells, headings]
    quarters = (turned - headings) % len(HEADINGS)
    is_move = (to == ahead) & (quarters == 0) & ~situation.stays
    is_turn = (to == cells) & np.where(situation.stays, quarters == 0, quarters != 2)
    for robot in np.flatnonzero(~is_place | ~(is_move | is_turn))[:1]:
        here, there = (str(graph.layout.cell(each[robot])) for each in (cells, to))
        state = f"robot {robot} heads {SIDES[headings[robot]]} at {here} and is to be at {there}"
        is_known = is_place[robot]
        raise PlanError(f"{state}, heading {SIDES[turned[robot]] if is_known else turned[robot]}")
    check_step(graph, situation, to)
    return checked
