"""Anytime planning: the best plan within a time limit, from LaCAM, guidance, proofs and LNS.

Each problem gets the methods that suit its size and density. LaCAM always makes the first plan.

On crowded floors, the first plan decides the quality. LaCAM is therefore run again with costs of
moves learned from the traffic of its previous plans, so that robots avoid one another. On den312d
with 1,000 robots, this lowers the cost from 5.6 to 3.3 times its lower bound in four seconds. A
windowed planner followed by LaCAM reached 5.1 times the bound, and refinement alone 5.5. In narrow
mazes, guidance often finds no plan quickly; there, LaCAM is run with other seeds, because its
makespan differs by a factor of 2 to 3 between seeds.

For small teams, CBS and LaCAM* may prove that a plan is optimal. For robots with headings, turns
are added to the best plan without headings. Finally LNS refines the plan.

Source: Chen, Harabor, Li and Stuckey (2024), Traffic flow optimisation for lifelong multi-agent
path finding, AAAI, for guidance by traffic.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from math import inf
from operator import attrgetter
from time import perf_counter

from agents.errors import PlanError
from agents.mapf.cbs import solve_cbs
from agents.mapf.guidance import Traffic
from agents.mapf.kernels.lacam import prepare_solvers
from agents.mapf.lacam import LaCAM, with_turns
from agents.mapf.lns import Refinement
from agents.mapf.problem import Plan, Problem
from warehouse_core.world.moves import HEADINGS

__all__ = ["solve_anytime"]

SMALL_TEAM = 8
"""Largest team for which CBS and LaCAM* try to prove that a plan is optimal."""

PROOF_SHARE = 0.4
"""Largest share of the time for each of these two."""

ROUNDS = 100
"""Rounds of LaCAM* for each trial if the number of trials is limited."""

CROWDED = 1.3
"""Ratio of cost to lower bound above which a floor counts as crowded."""

OTHERS = 8
"""Number of other first plans on a crowded floor, made with guidance or another seed."""

OTHERS_SHARE = 0.4
"""Largest share of the time for all of these plans. Each gets an eighth of it."""

PATIENCE = 40
"""Limit on the rounds for another first plan, for each step of the first one."""

PLAIN_SHARE = 0.4
"""Share of the time for a plan without headings, to which turns are added."""

COST = attrgetter("sum_of_costs")
"""Function that returns the cost of a plan, by which plans are compared."""

MAX_STATES = 100_000_000
"""Limit on cells times steps of a plan that is refined. Each takes 16 bytes of memory."""


def solve_anytime(problem: Problem, seconds: float, seed: int = 0, trials: float = inf) -> Plan:
    """Return the best plan that is found within a time limit.

    Args:
        problem: problem to solve.
        seconds: time limit by the clock.
        seed: seed of random tie-breaks and of groups.
        trials: groups that are replanned, after which the plan counts as good enough. The same
            number gives the same plan if the time suffices.

    Raises:
        PlanError: no plan exists, or none was found in time.

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
    begin = perf_counter()
    deadline, has_headings = begin + seconds, problem.headings is not None
    search = LaCAM(problem, seed)
    plan = search.run(max(deadline - perf_counter(), 0.0), goes_on=False)
    if has_headings:
        share = PLAIN_SHARE * max(deadline - perf_counter(), 0.0)
        with suppress(PlanError):  # its share may be too short for a plan
            plain = solve_anytime(replace(problem, headings=None), share, seed, trials)
            plan = min(plan, with_turns(problem, plain), key=COST)
    if not can_refine(problem, plan):
        return plan
    if problem.robots <= SMALL_TEAM:
        if not has_headings:
            with suppress(PlanError):
                return solve_cbs(problem, PROOF_SHARE * seconds)
        search.search(perf_counter() + PROOF_SHARE * seconds, ROUNDS * trials)
        better = search.plan() or plan
        if search.is_done:
            return better
        plan = min(plan, better, key=COST) if has_headings else better
    elif plan.sum_of_costs > CROWDED * search.lower_bound and not has_headings:
        others = _others(problem, plan, seed, begin + OTHERS_SHARE * seconds)
        plan = min([plan, *others], key=COST)
    refinement = Refinement(problem, plan, seed, search.steps)
    refinement.run(deadline, trials)
    return refinement.plan()


def can_refine(problem: Problem, plan: Plan) -> bool:
    """Return whether a plan has moves and is short enough to be refined."""
    places = problem.graph.size * (1 if problem.headings is None else len(HEADINGS))
    return 0 < plan.makespan * places < MAX_STATES


def _others(problem: Problem, first: Plan, seed: int, deadline: float) -> Iterator[Plan]:
    """Yield plans of LaCAM, each guided by the traffic of the previous one.

    If guidance finds no plan quickly, the next plan is made without it and with another seed.
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
