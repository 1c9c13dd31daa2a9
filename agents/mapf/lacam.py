"""LaCAM and LaCAM*: lazy constraints addition search over the places of all robots at once.

The search is complete: it ends with a plan or with the proof that none exists. LaCAM returns the
first plan, which it finds quickly. LaCAM* continues until the time is up or the plan is proved to
be optimal. See ``kernels/lacam.py`` for the search itself and its source.

For robots with headings, the first plan is made without headings and turns are added to it. Such a
plan exists exactly if there is a plan with headings. LaCAM* starts from this plan and searches with
headings.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from time import perf_counter

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import robots_in
from agents.mapf.kernels import lacam as kernels
from agents.mapf.kernels.buffers import write
from agents.mapf.kernels.epibt import epibt_of
from agents.mapf.kernels.lacam import prepare_solvers
from agents.mapf.kernels.local_guidance import guidance_of
from agents.mapf.kernels.pibt import pibt_of
from agents.mapf.kernels.places import NONE
from agents.mapf.kernels.robots import NOBODY, robots_of
from agents.mapf.problem import Plan, Problem
from warehouse_core.wording import counted
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers

__all__ = ["lacam", "lacam_star"]

DECISIONS = 10_000
"""Decisions of robots between two looks at the clock."""

MAX_NUMBERS = 150_000_000
"""Limit on the places in all configurations, after which the search ends. Each takes 16 bytes."""


def lacam(problem: Problem, seconds: float, seed: int = 0) -> Plan:
    """Return the first plan of LaCAM, which may be far from optimal.

    Raises:
        PlanError: no plan exists, or none was found in time.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lacam import lacam
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> lacam(problem, seconds=10).cells.tolist()
        [[0, 2], [1, 2], [0, 1], [1, 4], [2, 3], [2, 0]]
    """
    return LaCAM(problem, seed).run(seconds, goes_on=False)


def lacam_star(problem: Problem, seconds: float, seed: int = 0) -> Plan:
    """Return the best plan that LaCAM* finds in time, which may be proved to be optimal.

    The search minimizes the sum of the step costs. The cost of a step is the number of robots that
    are not at their goals both before and after it. If the optimum is proved, this sum is the
    ``bound`` of the plan, because no plan has a smaller sum of costs.

    Raises:
        PlanError: no plan exists, or none was found in time.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lacam import lacam_star
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> plan = lacam_star(problem, seconds=10)
        >>> plan.sum_of_costs, plan.bound
        (6, 6)
    """
    return LaCAM(problem, seed).run(seconds)


class LaCAM:
    """A search for plans of a problem that can pause and continue.

    Args:
        problem: problem to solve. The costs of moves guide the robots, but plans cost their steps.
        seed: seed of random tie-breaks.
        window: number of steps that local guidance plans ahead, 0 for no guidance. Robots with
            headings have none. See ``kernels/local_guidance.py``.

    Attributes:
        is_done: true if the search is complete, so that the plan is optimal or none exists.
        steps: distances in steps.
        lower_bound: sum of the shortest distances from starts to goals, in steps.
        longest_path: greatest of these distances.
    """

    def __init__(self, problem: Problem, seed: int = 0, window: int = 0) -> None:
        prepare_solvers()
        self.problem, self.is_done = problem, False
        self._plain: LaCAM | None = None
        if problem.headings is not None:
            self._plain = LaCAM(replace(problem, headings=None), seed)
        graph, goals = problem.graph, np.array(problem.goals, np.intp)
        fields = problem.fields(graph)
        rows = fields.rows(goals) * fields.graph.places
        self.steps = fields if fields.step == 1 else problem.fields(graph.with_costs())
        step_rows = self.steps.rows(goals) * fields.graph.places
        self._floor, self._fields, self._steps = fields.floor, fields.table, self.steps.table
        self._robots = robots = robots_of(graph.size, problem.robots, seed)
        write(robots, goals=goals, rows=rows, chosen=problem.places)
        self._pibt = pibt_of(graph.size, problem.robots, is_final=True)
        self._epibt = epibt_of(graph.neighbours[:, :WAIT], problem.robots)
        self._guidance = guidance_of(graph.size, problem.robots, window)
        left = self.steps.matrix.ravel()[step_rows + problem.places]
        self.lower_bound, self.longest_path = int(left.sum()), int(left.max(initial=0))
        ranks = np.argsort(-left, kind="stable")
        self._search = kernels.new_search(robots, self._floor, self._steps, ranks, step_rows)

    def run(self, seconds: float, *, goes_on: bool = True) -> Plan:
        """Return the best plan that is found within a time limit, or the first one.

        Raises:
            PlanError: no plan exists, or none was found in time.
        """
        self.search(perf_counter() + seconds, goes_on=goes_on)
        plan = self.plan()
        if plan is None:
            search = (self._plain or self)._search
            seen = counted(int(search.counts[kernels.NODES]), "configuration")
            if self.is_done:
                raise PlanError(f"there is no plan: LaCAM tried all {seen}")
            raise PlanError(f"LaCAM found no plan in {seconds:.3g} s; it saw {seen}")
        return plan

    def search(self, deadline: float, rounds: float = inf, *, goes_on: bool = True) -> None:
        """Search until a ``perf_counter`` deadline, or for this many rounds of PIBT or EPIBT.

        Without ``goes_on`` the search pauses as soon as it has a plan.
        """
        robots = self.problem.robots
        if self._plain is not None and self._search.counts[kernels.BEST] == NONE:
            self._plain.search(deadline, rounds, goes_on=False)
            plan = self._plain.plan()
            if plan is None:
                self.is_done = self._plain.is_done
                return
            self._begin_with(with_turns(self.problem, plan).places(self.problem.graph))
            if not goes_on:
                return
        self._search.counts[kernels.ANYTIME] = goes_on
        while not self.is_done and rounds > 0 and perf_counter() < deadline:
            portion = int(min(max(DECISIONS // max(robots, 1), 1), rounds))
            rounds -= portion
            status = kernels.explore(
                self._search, self._robots, self._pibt, self._epibt, self._guidance, self._floor,
                self._fields, self._steps, portion,
            )  # fmt: skip
            if status == kernels.FULL:
                if len(self._search.places) > MAX_NUMBERS:
                    return
                self._search = kernels.enlarged_search(self._search)
            elif status == kernels.FOUND:
                return
            self.is_done = status == kernels.DONE

    def plan(self) -> Plan | None:
        """Return the best plan so far."""
        search, robots = self._search, self.problem.robots
        best = int(search.counts[kernels.BEST])
        if best == NONE:
            return None
        places = np.array(kernels.best_places(search), np.int64).reshape(-1, robots)
        return self.problem.plan_of(places, int(search.cost[best]) if self.is_done else None)

    def _begin_with(self, places_by_step: Integers) -> None:
        """Add the configurations of a plan, ``[T + 1, R]`` places, and restart from the first."""
        node, robots, floor = 0, self._robots, self._floor
        for places in places_by_step[1:]:
            if kernels.is_full(self._search):
                self._search = kernels.enlarged_search(self._search)
            write(robots, chosen=places)
            slot = kernels.slot_of(self._search, robots.chosen, 0)
            after = int(self._search.table[slot]) - 1
            if after == NONE:
                after = kernels.add(self._search, robots, floor, self._steps, node, slot)
                kernels.add_edge(self._search, node, after)
            else:
                kernels.reach_again(self._search, robots, floor, node, after)
            node = after
        self._search.counts[kernels.BEST] = node
        kernels.push(self._search, 0)


def with_turns(problem: Problem, plan: Plan) -> Plan:
    """Return the plan for robots with headings that follows from a plan without headings.

    Each robot passes the cells of the given plan, and the robots pass each cell in the order of the
    given plan, so that all arrive. Apart from that, each robot turns and moves as soon as possible.
    """
    graph, cells = problem.graph, plan.cells
    robots = cells.shape[1]
    mover, time = np.nonzero((cells[1:] != cells[:-1]).T)
    here, to = cells[time, mover], cells[time + 1, mover]
    course = (graph.neighbours[here, :WAIT] == to[:, None]).argmax(axis=1)
    before = visits_before(cells[0], to, time)
    move, end = np.searchsorted(mover, [np.arange(robots), np.arange(1, robots + 1)])
    cell, headings = cells[0].copy(), np.array(problem.headings, np.intp)
    left = np.zeros(graph.size, np.intp)  # finished visits of each cell
    robot_in = robots_in(graph.size, cell)
    all_cells, all_headings = [cell.copy()], [headings.copy()]
    while (active := np.flatnonzero(move < end)).size:
        quarters = (course[move[active]] - headings[active]) % len(HEADINGS)
        ready = active[quarters == 0]
        goes = np.zeros(robots, np.bool_)
        goes[ready] = True
        while True:  # robots in a chain or a ring move at the same time or not at all
            ahead = to[move[ready]]
            missing, front = before[move[ready]] - left[ahead], robot_in[ahead]
            is_free = (missing == 0) | ((missing == 1) & (front != NOBODY) & goes[front])
            if is_free.all():
                break
            goes[ready[~is_free]] = False
            ready = ready[is_free]
        headings[active] += np.where(quarters == len(HEADINGS) - 1, -1, np.sign(quarters))
        headings %= len(HEADINGS)
        left[cell[ready]] += 1
        robot_in[cell[ready]] = NOBODY
        cell[ready] = to[move[ready]]
        robot_in[cell[ready]] = ready
        move[ready] += 1
        all_cells.append(cell.copy())
        all_headings.append(headings.copy())
    return Plan(np.array(all_cells), headings=np.array(all_headings))


def visits_before(starts: Integers, to: Integers, time: Integers) -> Integers:
    """Return the number of visits to each entered cell before the move, including starts."""
    cell = np.concatenate([starts, to])
    when = np.concatenate([np.full(len(starts), -1), time])
    order = np.lexsort((when, cell))
    in_order = cell[order]
    number = np.empty(len(cell), np.intp)
    number[order] = np.arange(len(cell)) - np.searchsorted(in_order, in_order)
    return number[len(starts) :]
