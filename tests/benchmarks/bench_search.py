"""A* against networkx in a warehouse and among random walls, and plans of deliveries.

In a warehouse there are many shortest paths, of which A* follows one and networkx widens all: most
of the ratio is expansions. Among random walls both expand about as many; what is left is the loop.
"""

import random
from collections.abc import Callable, Sequence
from statistics import median
from time import perf_counter

import networkx as nx
import pytest
from helpers.plan_validator import route_graph
from helpers.timing import seconds

from agents.search.agents import SearchAgent
from agents.search.algorithms import astar_search
from agents.search.heuristics import manhattan, manhattan_delivery
from agents.search.problems import DeliveryProblem, RouteProblem
from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, WarehouseEnv
from warehouse_core.world.generators import benchmark_warehouse

PAIRS = 200
PLANS = 1000
WALLS, SIZES = 0.3, (50, 100, 150)
"""Share of the cells that are walls, and the sides, of the layouts with random walls."""

MANY = 140, 500, 352, 3000
"""Rows, columns, pickups and dropoffs, about those of a warehouse of the League of Robot Runners
(``example_problems/warehouse.domain`` of its Start-Kit has 28,144 dropoffs)."""

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
    return random_pairs([warehouse.open_cell(i) for i in range(len(warehouse.open_cells))], PAIRS)


@pytest.fixture(scope="module")
def graph(warehouse: Layout) -> nx.Graph:
    return route_graph(warehouse.rows)


def random_pairs(cells: Sequence[Cell], count: int) -> list[Pair]:
    stream = random.Random(0)
    ends = [stream.choice(cells) for _ in range(2 * count)]
    return list(zip(ends[::2], ends[1::2], strict=True))


def random_walls(size: int) -> tuple[Layout, list[Pair]]:
    """Return a layout where each cell is a wall by chance, and pairs of connected cells."""
    stream = random.Random(size)
    rows = ["".join(".#"[stream.random() < WALLS] for _ in range(size)) for _ in range(size)]
    layout = Layout(rows)
    largest = max(nx.connected_components(route_graph(layout.rows)), key=len)
    return layout, random_pairs(sorted(largest), 40)


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


def test_the_estimate_for_many_stations_is_ten_times_as_fast_as_all_pairs(
    times_faster: Callable[..., float],
) -> None:
    height, width, pickups, dropoffs = MANY
    cells = [(row, col) for row in range(height) for col in range(width)]
    stream = random.Random(0)
    ends, goals = stream.sample(cells, pickups), stream.sample(cells, dropoffs)
    layout = Layout(["." * width] * height)
    problem = DeliveryProblem(layout, (0, 0), pickups=ends, dropoffs=goals)

    def best_pair() -> float:
        return min(
            2 + grid_distance((0, 0), end) + min(grid_distance(end, goal) for goal in goals)
            for end in ends
        )

    def estimate() -> float:
        return manhattan_delivery(problem)(problem.initial)

    assert estimate() == best_pair()
    assert times_faster(estimate, best_pair, 3) >= 10


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
