"""Refinement of a plan by large-neighbourhood search; see ``kernels/groups.py``."""

from __future__ import annotations

from math import inf
from time import perf_counter

import numpy as np

from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.buffers import buffer_of
from agents.mapf.kernels.groups import improve, new_groups
from agents.mapf.kernels.ways import new_frontier, new_ways, reserve
from agents.mapf.problem import Plan, Problem

TRIALS = 100
"""Groups between two looks at the clock."""

SLACK = 8
"""Steps that a robot may arrive after the last one so far."""


class Refinement:
    """Makes a plan cheaper by planning groups of robots anew; it is never worse.

    Args:
        problem: problem that the plan solves.
        plan: any plan without conflicts.
        seed: seed of the groups.
    """

    def __init__(self, problem: Problem, plan: Plan, seed: int = 0) -> None:
        self.problem = problem
        fields = Fields(Graph(problem.graph.layout))
        self._rows = fields.rows(np.array(problem.goals, np.intp)) * problem.graph.size
        self._floor, self._fields = fields.floor, fields.table
        self._groups_seed = seed
        self._begin(plan)

    def _begin(self, plan: Plan) -> None:
        floor, robots, times = self._floor, self.problem.robots, plan.makespan + 1 + SLACK
        self._ways = ways = new_ways(floor, robots, times, False)
        cells = np.concatenate([plan.cells, np.repeat(plan.cells[-1:], SLACK, axis=0)])
        np.asarray(ways.places)[:] = cells.T.ravel()
        ways.goals[:], ways.rows[:] = buffer_of(plan.cells[-1]), buffer_of(self._rows)
        ways.costs[:] = buffer_of(plan.costs)
        for robot in range(robots):
            reserve(floor, ways, robot, robot + 1)
        self._frontier = new_frontier(floor, ways)
        self._groups = new_groups(robots, times, self._groups_seed)

    def run(self, deadline: float, trials: float = inf) -> None:
        """Try groups until the deadline of ``perf_counter``, or so many."""
        portion = 10
        while trials > 0 and perf_counter() < deadline:
            number = int(min(portion, trials))
            trials -= number
            improve(self._floor, self._ways, self._frontier, self._groups, self._fields, number)

    def plan(self) -> Plan:
        """Return the plan so far."""
        places = np.asarray(self._ways.places).reshape(self.problem.robots, -1).T
        costs = np.asarray(self._ways.costs)
        return Plan(places[: costs.max(initial=0) + 1].astype(np.int64))
