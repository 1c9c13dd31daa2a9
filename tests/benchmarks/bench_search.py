"""A* compared with networkx in a warehouse and among random walls.

A warehouse has many shortest paths. A* follows one of them, while networkx explores all of them, so
that most of the speed comes from fewer expansions. Among random walls both expand about as many
nodes, so that the ratio compares the search loops.
"""

import random
from collections.abc import Callable, Sequence

import networkx as nx
import pytest
from helpers.plan_validator import route_graph

from agents.search.algorithms import astar_search
from agents.search.heuristics import manhattan
from agents.search.problems import RouteProblem
from warehouse_core import Cell, Layout
from warehouse_core.world.generators import benchmark_warehouse

PAIRS = 200
WALLS, SIZES = 0.3, (50, 100, 150)
"""Share of wall cells in the layouts with random walls, and their side lengths."""

Pair = tuple[Cell, Cell]


@pytest.fixture(scope="module")
def warehouse() -> Layout:
    """Return ``warehouse-20-40-10-2-1``, 321 x 123 cells."""
    layout = benchmark_warehouse(20, 40, 10, 2, 1)
    assert (layout.width, layout.height) == (321, 123)
    return layout


@pytest.fixture(scope="module")
def pairs(warehouse: Layout) -> list[Pair]:
    return random_pairs([warehouse.open_cell(i) for i in range(len(warehouse.open_cells))], PAIRS)


@pytest.fixture(scope="module")
def graph(warehouse: Layout) -> nx.Graph:
    return route_graph(warehouse.rows)


def random_pairs(cells: Sequence[Cell], count: int) -> list[Pair]:
    stream = random.Random(0)
    ends = [stream.choice(cells) for _ in range(2 * count)]
    return list(zip(ends[::2], ends[1::2], strict=True))


def random_walls(size: int) -> tuple[Layout, list[Pair]]:
    """Return a layout whose cells are walls at random, and pairs of connected cells."""
    stream = random.Random(size)
    rows = ["".join(".#"[stream.random() < WALLS] for _ in range(size)) for _ in range(size)]
    layout = Layout(rows)
    largest = max(nx.connected_components(route_graph(layout.rows)), key=len)
    return layout, random_pairs(sorted(largest), 40)


def grid_distance(here: Cell, there: Cell) -> int:
    return abs(here[0] - there[0]) + abs(here[1] - there[1])


def ours(layout: Layout, pairs: Sequence[Pair]) -> list[tuple[float, int]]:
    """Return the cost and the number of expansions of each search."""
    found = []
    for start, goal in pairs:
        problem = RouteProblem(layout, start, goal)
        solution = astar_search(problem, manhattan(problem))
        found.append((solution.cost, solution.expanded))
    return found


def theirs(graph: nx.Graph, pairs: Sequence[Pair]) -> list[int]:
    """Return the cost of each search with networkx."""
    return [len(nx.astar_path(graph, *ends, grid_distance)) - 1 for ends in pairs]


def test_in_a_warehouse_astar_is_ten_times_as_fast_as_networkx(
    warehouse: Layout, pairs: list[Pair], graph: nx.Graph, times_faster: Callable[..., float]
) -> None:
    assert [cost for cost, _ in ours(warehouse, pairs)] == theirs(graph, pairs)
    assert times_faster(lambda: ours(warehouse, pairs), lambda: theirs(graph, pairs), 3) >= 10


def test_among_random_walls_astar_is_one_and_a_half_times_as_fast_as_networkx(
    times_faster: Callable[..., float],
) -> None:
    cases = [
        (layout, pairs, route_graph(layout.rows)) for layout, pairs in map(random_walls, SIZES)
    ]

    def all_ours() -> list[list[int]]:
        return [[cost for cost, _ in ours(layout, pairs)] for layout, pairs, _ in cases]

    def all_theirs() -> list[list[int]]:
        return [theirs(graph, pairs) for _, pairs, graph in cases]

    assert all_ours() == all_theirs()
    assert times_faster(all_ours, all_theirs) >= 1.5
