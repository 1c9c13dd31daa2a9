"""Planners for robots whose goals change: they choose the next cell of each, step by step."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from agents.errors import PlanError
from agents.mapf.graph import CLOSED, Graph, robots_in
from agents.mapf.problem import Plan, Problem
from warehouse_core.wording import brief, counted
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

__all__ = ["Planner", "Situation"]

SIDES = ("north", "east", "south", "west")
"""Headings in words."""

NO_CELLS = np.empty(0, np.intp)


class Situation(NamedTuple):
    """What a planner knows of ``R`` robots before a joint step; cells are numbers.

    Attributes:
        cells: ``[R]``, cells of the robots, all different.
        goals: ``[R]``, cells to go to; several robots may have one goal. A robot that is to go
            nowhere has its own cell as goal, and gives way.
        stays: ``[R]``, true for robots that stay where they are in this step, because they pick,
            drop or charge, or have an empty battery.
        closed: cells that nobody can enter in this step, such as cells of people.
        urgent: robots that should go before all others, as those whose batteries are low.

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


@runtime_checkable
class Planner(Protocol):
    """Chooses the next cells of robots; each planner is made for one ``Graph``.

    A class of a user needs no more than these two methods. It may also have

    - ``next_places(situation, headings)``, for robots with headings; see ``PlacePlanner``,
    - ``graph``, whose costs its robots follow; cells that nobody can enter are closed there,
    - ``plan_of(robot)``, the cells of a robot after each of the next steps, of which the first is
      the cell just chosen,
    - ``pushers``, ``[R]``, the robot that made each robot choose before its turn in the last step,
      or ``NOBODY``.

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

        The step has no conflict: no two robots in one cell, no two that change places, nobody in
        a closed cell. Each cell is the robot's own or one beside it.
        """


def knows_headings(planner: Planner) -> bool:
    """Return whether a planner plans for robots that drive forward and turn on the spot."""
    return getattr(planner, "knows_headings", hasattr(planner, "next_places"))


def next_steps(planner: Planner, situation: Situation, headings: Integers) -> Integers:
    """Return what a planner chooses: places of robots with headings, or cells if there are none."""
    if len(headings):
        return cast(PlacePlanner, planner).next_places(situation, headings)
    return planner.next_cells(situation)


class PlacePlanner(ABC):
    """Base of planners that choose places, with headings and without.

    A subclass chooses places in ``_choose``, after it has begun an episode in ``_begin``.

    Attributes:
        graph: graph whose costs the robots follow.
        knows_headings: true if ``next_places`` plans for robots that drive forward and turn.
    """

    graph: Graph
    knows_headings = True

    def reset(self) -> None:
        """Forget the last episode, and begin again with the random numbers of the seed."""
        self._begun_for = 0, False

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step, ``[R]``."""
        return self._next(situation, None) % self.graph.size

    def next_places(self, situation: Situation, headings: Integers) -> Integers:
        """Return the place of each robot after the next joint step, ``[R]``.

        A place is ``heading * H * W + cell``. A robot moves to the cell that it heads for, or it
        keeps its cell and turns by a quarter at most; what ``next_cells`` says holds for the cells.

        Args:
            situation: situation of the robots, as for ``next_cells``.
            headings: ``[R]``, 0 to 3 for N, E, S and W.
        """
        return self._next(situation, headings * self.graph.size + situation.cells)

    def _next(self, situation: Situation, places: Integers | None) -> Integers:
        """Return the next place of each robot, given its present one if it has a heading."""
        if not len(situation.cells):
            return situation.cells
        episode = len(situation.cells), places is not None
        if episode != self._begun_for:
            self._begin(*episode)
            self._begun_for = episode
        return self._choose(situation, places)

    @abstractmethod
    def _begin(self, robots: int, has_headings: bool) -> None:
        """Begin an episode of so many robots."""

    @abstractmethod
    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        """Return the next place of each robot, given its present one if it has a heading."""


def solve_by_steps(planner: Planner, problem: Problem, seconds: float) -> Plan:
    """Return the steps until a planner has led all robots to their goals at once.

    Raises:
        PlanError: it did not in so many seconds by the clock; there may be a plan. Or the robots
            have headings, and the planner does not know headings.
    """
    deadline, size = time.perf_counter() + seconds, problem.graph.size
    places, goals = problem.places, np.array(problem.goals)
    nobody, way = np.zeros(len(places), np.bool_), [places]
    if not knows_headings(planner):
        problem.refuse_headings(f"planner {type(planner).__name__}")
    planner.reset()
    while (places % size != goals).any():
        if time.perf_counter() > deadline:
            raise PlanError(f"no plan after {seconds:g} s and {counted(len(way) - 1, 'step')}")
        headings, cells = np.divmod(places, size)
        situation = Situation(cells, goals, nobody, NO_CELLS)
        places = next_steps(planner, situation, NO_CELLS if problem.headings is None else headings)
        way.append(places)
    return problem.plan_of(np.array(way))


def check_step(graph: Graph, situation: Situation, chosen: object) -> Integers:
    """Return the next cells that a planner has chosen in a situation, checked.

    Robots that share a cell, as bodies may after a disturbance, stay there.

    Raises:
        PlanError: it is no cell for each robot, or a robot jumps, moves though it stays, enters a
            closed cell, or meets another; the message names robots and cells.
    """
    cells, stays = situation.cells, situation.stays
    found = np.asarray(chosen)
    if found.shape != cells.shape or found.dtype.kind not in "iu":
        raise PlanError(
            f"the planner returned {brief(chosen)}; needed: a cell number for each of "
            f"{len(cells)} robots"
        )

    def place(cell: np.integer) -> str:
        return str(graph.layout.cell(cell))

    is_near = (graph.neighbours[cells] == found[:, None]).any(axis=1) & (found != CLOSED)
    moves = found != cells
    for is_wrong, why in (
        (~is_near, "which is not an open cell beside it"),
        (moves & stays, "but it stays in this step"),
    ):
        for robot in np.flatnonzero(is_wrong)[:1]:
            way = f"from {place(cells[robot])} to {place(found[robot])}"
            raise PlanError(f"robot {robot} is to go {way}, {why}")
    is_closed = np.zeros(graph.size, np.bool_)
    is_closed[situation.closed] = True
    for robot in np.flatnonzero(moves & is_closed[found])[:1]:
        raise PlanError(f"robot {robot} is to enter {place(found[robot])}, which is closed")
    by_cell = np.argsort(found, kind="stable")
    first, second = by_cell[:-1], by_cell[1:]
    meets = (found[first] == found[second]) & (moves[first] | moves[second])
    for one, other in zip(first[meets][:1], second[meets][:1], strict=True):
        raise PlanError(f"robots {one} and {other} are both to be in {place(found[one])}")
    robot_in = robots_in(graph.size, cells)
    other_in = robot_in[found]
    swaps = moves & (other_in >= 0) & (found[other_in] == cells)
    for one in np.flatnonzero(swaps)[:1]:
        raise PlanError(
            f"robots {one} and {other_in[one]} are to change places, {place(cells[one])} and "
            f"{place(found[one])}"
        )
    return found


def check_turns(graph: Graph, situation: Situation, headings: Integers, chosen: object) -> Integers:
    """Return the next places that a planner has chosen for robots with headings, checked.

    Raises:
        PlanError: as for ``check_step``, or a robot moves where it does not head, turns round, or
            turns though it stays; the message names it.
    """
    cells = situation.cells
    found = np.asarray(chosen)
    if found.shape != cells.shape or found.dtype.kind not in "iu":
        raise PlanError(
            f"the planner returned {brief(chosen)}; needed: a place for each of {len(cells)} robots"
        )
    turned, to = np.divmod(found, graph.size)
    is_place = (found >= 0) & (turned < len(HEADINGS))
    ahead = graph.neighbours[cells, headings]
    quarters = (turned - headings) % len(HEADINGS)
    is_move = (to == ahead) & (quarters == 0) & ~situation.stays
    is_turn = (to == cells) & np.where(situation.stays, quarters == 0, quarters != 2)
    for robot in np.flatnonzero(~is_place | ~(is_move | is_turn))[:1]:
        here, there = (str(graph.layout.cell(each[robot])) for each in (cells, to))
        way = f"robot {robot} heads {SIDES[headings[robot]]} at {here} and is to be at {there}"
        is_known = is_place[robot]
        raise PlanError(f"{way}, heading {SIDES[turned[robot]] if is_known else turned[robot]}")
    check_step(graph, situation, to)
    return found
