"""The best plan in the time that there is: LaCAM, guidance or proofs, and refinement.

On crowded floors the first plan decides. There LaCAM is run again with costs of moves that follow
from the traffic of its last plans, so that robots keep out of one another's way: on den312d with
1,000 robots that brings the cost from 5.6 to 3.3 times its lower bound in four seconds. Windows
first, and then LaCAM, brought 5.1; refinement alone 5.5. In narrow mazes guidance often leads to no
plan soon, but the makespan of LaCAM's own plans differs by a factor of 2 to 3 from seed to seed.
Robots with headings get the turns that a plan without them needs, and that plan is refined.

Source: Chen, Harabor, Li and Stuckey (2024), Traffic flow optimisation for lifelong multi-agent
path finding, AAAI, for guidance by traffic.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from math import inf
from time import perf_counter

from agents.errors import PlanError
from agents.mapf.cbs import solve_cbs
from agents.mapf.kernels.lacam import prepare_solvers
from agents.mapf.lacam import LaCAM, lacam
from agents.mapf.lns import Refinement
from agents.mapf.problem import Plan, Problem
from agents.mapf.traffic import Traffic
from agents.mapf.turning import with_turns
from warehouse_core.world.moves import HEADINGS

__all__ = ["solve_anytime"]

SMALL_TEAM = 8
"""Most robots for which CBS and LaCAM* may prove that a plan is the best."""

PROOF_SHARE = 0.4
"""Most of the time that each of the two takes."""

ROUNDS = 100
"""Rounds of LaCAM* for each trial, where the number of trials is limited."""

CROWDED = 1.3
"""Cost over the lower bound from which on a floor is crowded."""

OTHERS = 8
"""Other first plans that are tried on a crowded floor, with guidance or another seed."""

OTHERS_SHARE = 0.4
"""Most of the time that they take, an eighth of it each."""

PATIENCE = 40
"""Rounds for each step of the first plan after which another is given up, if it is not for time."""

PLAIN_SHARE = 0.4
"""Time for a plan without headings, to which turns are added."""

MAX_STATES = 100_000_000
"""Cells times steps of a plan up to which it is refined; each takes 16 bytes."""


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

    Example:
        >>> from agents.mapf.anytime import solve_anytime
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> solve_anytime(problem, seconds=10, trials=10).sum_of_costs
        6
    """
    prepare_solvers()
    if problem.headings is not None:
        return _solve_with_turns(problem, seconds, seed, trials)
    begin = perf_counter()
    deadline = begin + seconds
    search = LaCAM(problem, seed)
    plan = search.run(max(deadline - perf_counter(), 0.0), goes_on=False)
    if not can_refine(problem, plan):
        return plan
    if plan.sum_of_costs > CROWDED * search.lower_bound and problem.robots > SMALL_TEAM:
        others = _others(problem, plan, seed, begin + OTHERS_SHARE * seconds)
        plan = min([plan, *others], key=lambda each: each.sum_of_costs)
    if problem.robots <= SMALL_TEAM:
        with suppress(PlanError):
            return solve_cbs(problem, PROOF_SHARE * seconds)
        search.search(perf_counter() + PROOF_SHARE * seconds, ROUNDS * trials)
        plan = search.plan() or plan
        if search.is_done:
            return plan
    refinement = Refinement(problem, plan, seed, search.steps)
    refinement.run(deadline, trials)
    return refinement.plan()


def can_refine(problem: Problem, plan: Plan) -> bool:
    """Return whether robots move in a plan, and it is not too long to be refined."""
    places = problem.graph.size * (1 if problem.headings is None else len(HEADINGS))
    return 0 < plan.makespan * places < MAX_STATES


def _solve_with_turns(problem: Problem, seconds: float, seed: int, trials: float) -> Plan:
    """Return the best plan of robots with headings; see ``solve_anytime``.

    What is refined is the best plan without headings, to which turns are added.
    """
    deadline = perf_counter() + seconds
    plan = lacam(problem, seconds, seed)
    share = PLAIN_SHARE * max(deadline - perf_counter(), 0.0)
    with suppress(PlanError):  # its share may be too short for a plan
        plain = solve_anytime(replace(problem, headings=None), share, seed, trials)
        plan = min(plan, with_turns(problem, plain), key=lambda each: each.sum_of_costs)
    if not can_refine(problem, plan):
        return plan
    if problem.robots <= SMALL_TEAM:
        search = LaCAM(problem, seed)
        search.search(perf_counter() + PROOF_SHARE * seconds, ROUNDS * trials)
        found = search.plan() or plan
        if search.is_done:
            return found
        plan = min(plan, found, key=lambda each: each.sum_of_costs)
    refinement = Refinement(problem, plan, seed)
    refinement.run(deadline, trials)
    return refinement.plan()


def _others(problem: Problem, first: Plan, seed: int, deadline: float) -> Iterator[Plan]:
    """Yield plans that LaCAM makes with guidance by the last one.

    After guidance that leads to no plan soon, one is made without it, with another seed.
    """
    last: Plan | None = first
    learned = Traffic(problem.graph.layout)
    share = (deadline - perf_counter()) / OTHERS
    for _ in range(OTHERS):
        if perf_counter() > deadline:
            return
        if last is not None:
            learned.add(last.cells)
            graph = problem.graph.with_costs(learned.costs)
            search = LaCAM(replace(problem, graph=graph), seed)
        else:
            seed += 1
            search = LaCAM(problem, seed)
        search.search(perf_counter() + share, PATIENCE * first.makespan, goes_on=False)
        last = search.plan()
        if last is not None:
            yield last
