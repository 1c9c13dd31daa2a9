"""Problems and situations of several robots, and smallest sums of costs by brute force."""

import random
from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import product

import networkx as nx
import numpy as np

from agents.mapf.graph import Graph
from agents.mapf.planner import Situation
from agents.mapf.problem import Problem
from helpers.mapf_turns import meets
from helpers.plan_validator import random_rows, route_graph
from warehouse_core import Layout


def random_problems(
    count: int, seed: int = 0, max_size: int = 9, max_robots: int = 8
) -> Iterator[Problem]:
    """Return problems on small floors with random walls; some of them have no solution.

    The floor is often in several parts; each robot's start and goal are in one part.
    """
    stream = random.Random(seed)
    for _ in range(count):
        rows = random_rows(stream, max_size=max_size)
        parts = [sorted(part) for part in nx.connected_components(route_graph(rows))]
        part = max(parts, key=len)
        robots = stream.randint(1, min(max_robots, len(part)))
        starts, goals = (
            [row * len(rows[0]) + col for row, col in stream.sample(part, robots)] for _ in range(2)
        )
        yield Problem(Graph(Layout(rows)), starts, goals)


def problem_of(rows: list[str], starts: Sequence[int], goals: Sequence[int]) -> Problem:
    return Problem(Graph(Layout(rows)), starts, goals)


def situation(
    cells: Sequence[int],
    goals: Sequence[int] | None = None,
    stays: Sequence[int] = (),
    closed: Sequence[int] = (),
) -> Situation:
    """Return a situation in which some robots stay; without ``goals`` all are at their goals."""
    flags = np.isin(np.arange(len(cells)), stays)
    goals = cells if goals is None else goals
    return Situation(np.array(cells), np.array(goals), flags, np.array(closed, np.intp))


def random_problem(layout: Layout, robots: int, seed: int) -> Problem:
    """Return a problem with random starts and goals on a connected floor."""
    stream, cells = random.Random(seed), layout.open_cells.tolist()
    return Problem(Graph(layout), stream.sample(cells, robots), stream.sample(cells, robots))


def smallest_cost(rows: Sequence[str], starts: Sequence[int], goals: Sequence[int]) -> int | None:
    """Return the smallest sum of costs, or ``None`` if there is no plan: a joint A*.

    A robot costs 1 in each step until it stays in its goal for good. A state includes which robots
    have ended, so that the cost depends on the state alone, and these robots no longer move.
    """
    width, graph = len(rows[0]), route_graph(rows)
    first, ends = (tuple(divmod(cell, width) for cell in cells) for cells in (starts, goals))
    fields = [nx.single_source_shortest_path_length(graph, end) for end in ends]

    def estimate(cells) -> int:
        return sum(field[cell] for field, cell in zip(fields, cells, strict=True))

    start = first, (False,) * len(first)
    best, heap, settled = {start: 0}, [(estimate(first), *start)], set()
    while heap:
        bound, cells, done = heappop(heap)
        if all(done):
            return bound
        if (cells, done) in settled:
            continue
        settled.add((cells, done))
        cost = best[cells, done]
        choices = [
            [(cell, True)]
            if ended
            else [(cell, False), *((place, False) for place in graph[cell])]
            + [(cell, True)] * (cell == end)
            for cell, ended, end in zip(cells, done, ends, strict=True)
        ]
        for joint in product(*choices):
            to, ended = tuple(cell for cell, _ in joint), tuple(flag for _, flag in joint)
            if meets(cells, to):
                continue
            total = cost + ended.count(False)
            if total < best.get((to, ended), total + 1):
                best[to, ended] = total
                heappush(heap, (total + estimate(to), to, ended))
    return None
