"""LNS, large neighborhood search: refinement of a plan; see ``kernels/lns.py``."""

from __future__ import annotations

from math import inf

import numpy as np

from agents.mapf.graph import Fields
from agents.mapf.kernels.buffers import write
from agents.mapf.kernels.lns import improve_until, new_groups
from agents.mapf.kernels.space_time_astar import new_frontier, new_routes, reserve_only
from agents.mapf.problem import Plan, Problem

SLACK = 8
"""Number of steps by which a robot may arrive later than the last robot of the first plan."""


class Refinement:
    """Refinement of a plan by replanning groups of robots; the plan never becomes worse.

    The plan must solve the problem without conflicts. ``steps`` are distances in steps, if they are
    known.
    """

    def __init__(
        self, problem: Problem, plan: Plan, seed: int | None = 0, steps: Fields | None = None
    ) -> None:
        self._problem, graph = problem, problem.graph
        fields = steps or problem.fields(graph.with_costs())
        goals, robots = np.array(problem.goals, np.intp), problem.robots
        rows = fields.rows(goals) * fields.graph.places
        self._floor, self._fields = fields.floor, fields.table
        times = plan.makespan + 1 + SLACK
        self._routes = routes = new_routes(self._floor, robots, times, is_open=False)
        places = plan.places(graph)
        places = np.concatenate([places, np.repeat(places[-1:], SLACK, axis=0)])
        np.asarray(routes.places)[:] = places.T.ravel()
        write(routes, goals=goals, rows=rows, costs=plan.costs)
        reserve_only(self._floor, routes, np.arange(robots))
        self._frontier = new_frontier(self._floor, routes)
        self._groups = new_groups(robots, times, seed)

    def run(self, deadline: float, trials: float = inf) -> int:
        """Replan ``trials`` groups or stop at a ``perf_counter`` deadline; return the number."""
        search = self._floor, self._routes, self._frontier, self._groups, self._fields
        return improve_until(*search, deadline, trials)

    def plan(self) -> Plan:
        """Return the current plan."""
        places = np.asarray(self._routes.places, np.int64).reshape(len(self._routes.costs), -1).T
        return self._problem.plan_of(places[: max(self._routes.costs, default=0) + 1])
