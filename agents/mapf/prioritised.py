"""Prioritised planning: the robots are planned one after the other, each around those before it.

Source: Silver (2005), Cooperative pathfinding, AIIDE: cooperative A*.
"""

from __future__ import annotations

import random
from math import factorial
from time import perf_counter

from agents.errors import PlanError
from agents.mapf.problem import Plan, Problem
from agents.mapf.space_time import Reservations, find_way, moves_of
from warehouse_core.wording import counted

__all__ = ["solve_prioritised"]


def solve_prioritised(problem: Problem, seconds: float) -> Plan:
    """Return a plan by cooperative A*; see ``problem.Solver``.

    The robots with the longest ways are first. If one finds no way it becomes the first of all,
    and an order that was tried before is shuffled, until the time is up.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.prioritised import solve_prioritised
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> solve_prioritised(problem, seconds=10).sum_of_costs
        6
    """
    problem.refuse_headings("prioritised planning")
    deadline, stream = perf_counter() + seconds, random.Random(0)
    moves, starts, goals = moves_of(problem.graph), problem.starts, problem.goals
    fields = [problem.graph.distances(goal).tolist() for goal in goals]
    order = sorted(range(problem.robots), key=lambda robot: -fields[robot][starts[robot]])
    tried, failed = set[tuple[int, ...]](), None
    while len(tried) < factorial(problem.robots):
        if tuple(order) in tried:
            stream.shuffle(order)
            continue
        tried.add(tuple(order))
        taken, ways = Reservations(problem.graph.size), dict[int, list[int]]()
        try:
            for robot in order:
                start, goal = starts[robot], goals[robot]
                way = find_way(moves, fields[robot], start, goal, taken, deadline)
                if way is None:
                    failed = robot
                    break
                taken.add(way)
                ways[robot] = way
            else:
                return Plan.of([ways[robot] for robot in range(problem.robots)])
        except TimeoutError:
            why = "" if failed is None else f"; robot {failed} had no way in the last that failed"
            orders = counted(len(tried), "order")
            raise PlanError(f"no plan in {seconds:g} s and {orders} of priorities{why}") from None
        order.remove(robot)
        order.insert(0, robot)
    raise PlanError(f"no order of priorities has a plan; robot {failed} had no way in the last")
