"""A* on a benchmark warehouse against networkx, and a plan on the chapter's layout."""

import random
from collections.abc import Callable, Sequence
from statistics import median
from time import perf_counter

import networkx as nx
import pytest
from helpers.timing import seconds

from agents.search.agents import SearchAgent
from agents.search.algorithms import astar_search
from agents.search.heuristics import manhattan, manhattan_delivery
from agents.search.problems import DeliveryProblem, RouteProblem
from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, WarehouseEnv
from warehouse_core.world.generators import benchmark_warehouse

PAIRS = 200
PLANS = 1000

Pair = tuple[Cell, Cell]
Weight = Callable[[Cell, Cell, object], float]


@pytest.fixture(scope="module")
def warehouse() -> Layout:
    """Return ``warehouse-20-40-10-2-1``, 321 x 123 cells."""
    layout = benchmark_warehouse(20, 40, 10, 2, 1)
    assert (layout.width, layout.height) == (321, 123)
    return layout


@pytest.fixture(scope="module")
def pairs(warehouse: Layout) -> list[Pair]:
    stream, count = random.Random(0), len(warehouse.open_cells)
    ends = [warehouse.open_cell(stream.randrange(count)) for _ in range(2 * PAIRS)]
    return list(zip(ends[::2], ends[1::2], strict=True))


@pytest.fixture(scope="module")
def graph(warehouse: Layout) -> nx.Graph:
    """Return the same map as a graph of networkx."""
    rows = warehouse.rows
    graph = nx.grid_2d_graph(warehouse.height, warehouse.width)
    walls = [(r, c) for r, row in enumerate(rows) for c, tile in enumerate(row) if tile == "#"]
    graph.remove_nodes_from(walls)
    return graph


def grid_distance(here: Cell, there: Cell) -> int:
    return abs(here[0] - there[0]) + abs(here[1] - there[1])


def ours(layout: Layout, pairs: Sequence[Pair]) -> list[tuple[float, int]]:
    """Return the cost and the expansions of each route."""
    found = []
    for start, goal in pairs:
        problem = RouteProblem(layout, start, goal)
        solution = astar_search(problem, manhattan(problem))
        found.append((solution.cost, solution.expanded))
    return found


def theirs(graph: nx.Graph, pairs: Sequence[Pair], weight: Weight | None = None) -> list[int]:
    """Return the cost of each route."""
    return [
        len(nx.astar_path(graph, start, goal, grid_distance, weight or "weight")) - 1
        for start, goal in pairs
    ]


def their_expansions(graph: nx.Graph, pair: Pair) -> int:
    """Count the nodes whose edge weights networkx reads."""
    seen = set()

    def weight(here: Cell, there: Cell, edge: object) -> float:
        seen.add(here)
        return 1.0

    theirs(graph, [pair], weight)
    return len(seen)


def test_astar_is_ten_times_as_fast_as_networkx(
    warehouse: Layout, pairs: list[Pair], graph: nx.Graph, times_faster: Callable[..., float]
) -> None:
    assert [cost for cost, _ in ours(warehouse, pairs)] == theirs(graph, pairs)
    assert times_faster(lambda: ours(warehouse, pairs), lambda: theirs(graph, pairs), 3) >= 10


def test_astar_expands_no_more_than_networkx(
    warehouse: Layout, pairs: list[Pair], graph: nx.Graph, capsys: pytest.CaptureFixture[str]
) -> None:
    """In total; for a single pair it may differ, as equal nodes are expanded in another order."""
    mine = [expanded for _, expanded in ours(warehouse, pairs)]
    others = [their_expansions(graph, pair) for pair in pairs]
    fewer = sum(one <= other for one, other in zip(mine, others, strict=True))
    with capsys.disabled():
        print(
            f"\nexpansions: {sum(mine)} to {sum(others)}, ratio {sum(others) / sum(mine):.2f}; "
            f"as many or fewer on {fewer} of {PAIRS} pairs"
        )
    assert sum(mine) <= sum(others)


def test_both_legs_on_the_default_grid_take_less_than_a_millisecond(
    times_faster: Callable[..., float], capsys: pytest.CaptureFixture[str]
) -> None:
    """A thousand plans, against a loop that reads the clock for a second."""

    def plan() -> None:
        problem = DeliveryProblem(DEFAULT_LAYOUT, (1, 1))
        assert astar_search(problem, manhattan_delivery(problem)).found

    def a_millisecond_each() -> None:
        end = perf_counter() + PLANS * 1e-3
        while perf_counter() < end:
            pass

    ratio = times_faster(lambda: [plan() for _ in range(PLANS)], a_millisecond_each, 3)
    with capsys.disabled():
        print(f"both legs on the default grid: {1 / ratio:.3f} ms")
    assert ratio > 1


def test_a_step_of_a_plan_is_about_as_fast_as_a_dictionary_lookup(capsys) -> None:
    """Less than 2 microseconds more, as the median of alternating rounds."""
    agent, env = SearchAgent(DEFAULT_LAYOUT), WarehouseEnv()
    observation = env.reset(randomize=True, seed=12)
    agent.act(observation)
    table = {(observation["robot_pos"], observation["has_item"]): "E"}
    count = 20_000

    def ask_agent() -> None:
        for _ in range(count):
            agent.act(observation)

    def ask_table() -> None:
        for _ in range(count):
            table[observation["robot_pos"], observation["has_item"]]

    more = [seconds(ask_agent) - seconds(ask_table) for _ in range(15)]
    microseconds = median(more) / count * 1e6
    with capsys.disabled():
        print(f"\na step of SearchAgent: {microseconds:.2f} us more than a lookup in a table")
    assert microseconds < 2
