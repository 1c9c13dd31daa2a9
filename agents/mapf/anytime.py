"""The best plan in the time that there is: LaCAM, then refinement, and LaCAM* for small teams."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from time import perf_counter

from agents.mapf.kernels.prepare import prepare_solvers
from agents.mapf.lacam import LaCAM
from agents.mapf.problem import Plan, Problem
from agents.mapf.refinement import Refinement

SMALL_TEAM = 8
"""Most robots for which LaCAM* has half of the time, since it may prove that a plan is the best."""

TURN = 0.05
"""Seconds that each has in turn."""


def solve_anytime(problem: Problem, seconds: float, seed: int = 0, trials: float = inf) -> Plan:
    """Return the best plan that is found in so many seconds by the clock.

    Args:
        problem: problem to solve.
        seconds: limit of time.
        seed: seed of random tie-breaks and of groups.
        trials: groups that are planned anew, after which the plan is good enough. The same number
            gives the same plan, if the time is long enough.

    Raises:
        PlanError: there is no plan, or none was found in time.
    """
    prepare_solvers()
    search = LaCAM(problem, seed)
    deadline = perf_counter() + seconds
    plan = search.run(seconds, goes_on=False)
    refinement = Refinement(problem, plan, seed, search.steps)
    while trials > 0 and perf_counter() < deadline:
        trials -= refinement.run(min(deadline, perf_counter() + TURN), trials)
        plan = refinement.plan()
        if problem.robots <= SMALL_TEAM:
            search.search(min(deadline, perf_counter() + TURN))
            found = search.plan() or plan
            plan = replace(min(plan, found, key=lambda each: each.sum_of_costs), bound=found.bound)
            if plan.bound == plan.sum_of_costs:
                break
    return plan
