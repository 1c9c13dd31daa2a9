"""Anytime planning: the best plan within a time limit, from LaCAM, guidance, proofs and LNS.

Each problem gets the methods that suit its size and density. LaCAM usually makes the first plan. On
crowded floors, this plan decides the quality, so LaCAM is run again with local guidance, in which
robots plan their next steps around one another. For small teams, CBS and LaCAM* may prove that a
plan is optimal. For robots with headings, turns are added to the best plan without headings.
Finally LNS refines the plan.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from math import inf
from operator import attrgetter
from time import perf_counter

from agents.errors import PlanError
from agents.mapf.cbs import solve_cbs
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

FIRST_SHARE = 0.2
"""Share of the time for a first plan, after which guided searches look for one."""

WINDOWS = 16, 40
"""Numbers of steps that guidance plans ahead; guided searches use them in turn.

On 16 random floors with 400 robots on 785 cells, plans cost 3.7 times the lower bound without
guidance, and 2.9, 2.5 and 2.3 times with windows of 10, 16 and 48 steps. Longer windows take more
time, and fail more often.
"""

ATTEMPTS = 6
"""Limit on guided searches, each of which has another seed."""

GUIDED_SHARE, MORE_SHARE = 0.7, 0.6
"""Shares of the time after which the first guided plan, and more of them, are no longer sought."""

PATIENCE = 25
"""Limit on the rounds of a guided search, for each step of the longest of the shortest paths."""

PLAIN_SHARE = 0.4
"""Share of the time for a plan without headings, to which turns are added."""

COST = attrgetter("sum_of_costs")
"""Function that returns the cost of a plan, by which plans are compared."""

MAX_STATES = 100_000_000
"""Limit on cells times steps of a plan that is refined. Each takes 16 bytes of memory."""

MAX_GUIDED = 5_000_000
"""Limit on cells times steps of a guided search. Each takes 50 bytes of memory."""


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
    search, is_small = LaCAM(problem, seed), problem.robots <= SMALL_TEAM
    plan = None if has_headings or is_small else _guided(search, seed, begin, seconds)
    if plan is None:
        plan = search.run(max(deadline - perf_counter(), 0.0), goes_on=False)
    if has_headings:
        share = PLAIN_SHARE * max(deadline - perf_counter(), 0.0)
        with suppress(PlanError):  # its share may be too short for a plan
            plain = solve_anytime(replace(problem, headings=None), share, seed, trials)
            plan = min(plan, with_turns(problem, plain), key=COST)
    places = problem.graph.size * (len(HEADINGS) if has_headings else 1)
    if not 0 < plan.makespan * places < MAX_STATES:
        return plan  # no robot moves, or refining takes too much memory
    if is_small:
        if not has_headings:
            with suppress(PlanError):
                return solve_cbs(problem, PROOF_SHARE * seconds)
        search.search(perf_counter() + PROOF_SHARE * seconds, ROUNDS * trials)
        better = search.plan() or plan
        if search.is_done:
            return better
        plan = min(plan, better, key=COST) if has_headings else better
    refinement = Refinement(problem, plan, seed, search.steps)
    refinement.run(deadline, trials)
    return refinement.plan()


def _guided(search: LaCAM, seed: int, start: float, seconds: float) -> Plan | None:
    """Return the best first plan of a search and, on crowded floors, of guided searches, if any.

    Args:
        search: search without guidance.
        seed: seed of the first guided search.
        start: begin of the planning, in seconds of ``perf_counter``.
        seconds: time limit from then on.
    """
    search.search(start + FIRST_SHARE * seconds, goes_on=False)
    problem, plan, is_found = search.problem, search.plan(), False
    for attempt in range(0 if search.is_done else ATTEMPTS):
        window = WINDOWS[attempt % len(WINDOWS)]
        deadline = start + (MORE_SHARE if is_found else GUIDED_SHARE) * seconds
        is_good = plan is not None and plan.sum_of_costs <= CROWDED * search.lower_bound
        if is_good or perf_counter() > deadline or window * problem.graph.size > MAX_GUIDED:
            break
        guided = LaCAM(problem, seed + attempt, window)
        guided.search(deadline, PATIENCE * search.longest_path, goes_on=False)
        if (found := guided.plan()) is not None:
            plan, is_found = found if plan is None else min(plan, found, key=COST), True
    return plan
