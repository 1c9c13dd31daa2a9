"""Best-first search and its algorithms, on Russell and Norvig's map and on small ones."""

import math
import random
from collections.abc import Callable

import networkx as nx
import pytest
from helpers.plan_validator import open_places, random_rows, replay_route, route_graph
from helpers.romania import Travel, romania, straight_line

from agents.search.algorithms import (
    Solution,
    astar_search,
    best_first_search,
    breadth_first_search,
    greedy_best_first_search,
    uniform_cost_search,
    weighted,
    weighted_astar_search,
)
from agents.search.heuristics import manhattan, zero
from agents.search.problems import RouteProblem
from warehouse_core import Layout

Search = Callable[[Travel], Solution[str, str]]
SEARCHES: dict[str, Search] = {
    "breadth-first": breadth_first_search,
    "uniform-cost": uniform_cost_search,
    "greedy": lambda problem: greedy_best_first_search(problem, zero),
    "A*": lambda problem: astar_search(problem, zero),
    "weighted A*": lambda problem: weighted_astar_search(problem, zero, 2.0),
}
over_searches = pytest.mark.parametrize("search", SEARCHES.values(), ids=SEARCHES)

ROUTES = 200

VIA_PITESTI = ("Arad", "Sibiu", "Rimnicu Vilcea", "Pitesti", "Bucharest")
VIA_FAGARAS = ("Arad", "Sibiu", "Fagaras", "Bucharest")

DETOUR = {("S", "A"): 1, ("S", "B"): 5, ("A", "C"): 0.5, ("A", "B"): 1, ("B", "G"): 10}
"""From S to G by A and B; C is a dead end, and the road from S to B is long."""


def expanded(solution: Solution[str, str]) -> list[object]:
    return [event.expanded for event in solution.events]


def random_route(stream: random.Random) -> tuple[list[str], RouteProblem]:
    rows = random_rows(stream)
    start, goal = (stream.choice(open_places(rows)) for _ in range(2))
    return rows, RouteProblem(Layout(rows), start, goal)


def test_astar_goes_to_bucharest_through_pitesti() -> None:
    """Figure 3.18: the cities in the order of their expansion, each with its f = g + h."""
    evaluations: dict[tuple[str, float], float] = {}
    astar = weighted(straight_line, 1.0)

    def evaluate(state: str, cost: float) -> float:
        evaluations[state, cost] = astar(state, cost)
        return evaluations[state, cost]

    found = best_first_search(romania(), evaluate, with_events=True)
    assert (found.states, found.cost) == (VIA_PITESTI, 418)
    assert expanded(found) == ["Arad", "Sibiu", "Rimnicu Vilcea", "Fagaras", "Pitesti"]
    assert evaluations == {
        ("Arad", 0): 366, ("Sibiu", 140): 393, ("Timisoara", 118): 447, ("Zerind", 75): 449,
        ("Fagaras", 239): 415, ("Oradea", 291): 671, ("Rimnicu Vilcea", 220): 413,
        ("Craiova", 366): 526, ("Pitesti", 317): 417, ("Bucharest", 450): 450,
        ("Bucharest", 418): 418,
    }  # fmt: skip
    assert found == astar_search(romania(), straight_line, with_events=True)


def test_greedy_search_goes_through_fagaras() -> None:
    """Figure 3.17: 32 miles more than the optimum; only cities on the path are expanded."""
    found = greedy_best_first_search(romania(), straight_line, with_events=True)
    assert (found.states, found.cost) == (VIA_FAGARAS, 450)
    assert expanded(found) == ["Arad", "Sibiu", "Fagaras"]


def test_uniform_cost_search_finds_the_shortest_path_and_expands_the_nearest_first() -> None:
    """The distances from Arad grow, and every city nearer than Bucharest has been expanded."""
    found = uniform_cost_search(romania(), with_events=True)
    assert (found.states, found.cost) == (VIA_PITESTI, 418)
    assert expanded(found) == [
        "Arad", "Zerind", "Timisoara", "Sibiu", "Oradea", "Rimnicu Vilcea", "Lugoj", "Fagaras",
        "Mehadia", "Pitesti", "Craiova", "Drobeta",
    ]  # fmt: skip


def test_the_counts_of_a_search_equal_those_found_by_hand() -> None:
    """S generates A at cost 1 and B at 5, A generates C at 1.5 and B at 2, B at 2 generates G.

    C generates nothing. After A the frontier has three nodes: C and B at both costs.
    """
    found = uniform_cost_search(Travel(DETOUR, "S", "G"), with_events=True)
    assert (found.states, found.actions) == (("S", "A", "B", "G"), ("A", "B", "G"))
    assert found.cost == 12
    assert (found.generated, found.expanded, found.largest_frontier) == (6, 4, 3)
    assert found.events == (("S", ("A", "B")), ("A", ("C", "B")), ("C", ()), ("B", ("G",)))
    near = uniform_cost_search(Travel(DETOUR, "S", "A"))
    assert (near.generated, near.expanded, near.largest_frontier) == (3, 1, 2)


def test_a_path_that_is_not_cheaper_does_not_replace_the_first() -> None:
    """The road back to S and the second of two equal paths to G are generated and not used."""
    roads = {("S", "A"): 1, ("S", "B"): 1, ("A", "S"): 1, ("A", "G"): 1, ("B", "G"): 1}
    found = uniform_cost_search(Travel(roads, "S", "G"), with_events=True)
    assert found.events == (("S", ("A", "B")), ("B", ("G",)), ("A", ()))
    assert (found.states, found.generated) == (("S", "B", "G"), 6)
    roads["B", "G"] = 2
    found = uniform_cost_search(Travel(roads, "S", "G"), with_events=True)
    assert found.events == (("S", ("A", "B")), ("B", ("G",)), ("A", ("G",)))
    assert (found.states, found.generated) == (("S", "A", "G"), 6)


def test_of_equal_evaluations_the_last_generated_is_expanded_first() -> None:
    layout = Layout(["....", "....", "...."])
    problem = RouteProblem(layout, (0, 0), (2, 3))
    found = astar_search(problem, manhattan(problem))
    assert found.expanded == 5, "straight to the goal, though all cells have the same evaluation"


@over_searches
def test_a_start_on_the_goal_needs_no_actions(search: Search) -> None:
    found = search(Travel(DETOUR, "S", "S"))
    assert found == Solution(("S",), (), 0.0, generated=1, expanded=0, largest_frontier=1)
    assert found.found


@over_searches
def test_without_a_path_there_is_no_solution(search: Search) -> None:
    found = search(Travel(DETOUR, "S", "nowhere"))
    assert not found.found
    assert (found.states, found.actions, found.cost) == ((), (), math.inf)
    assert found.expanded >= 5, "all reachable states were expanded"


@pytest.mark.parametrize("cost", [-1.0, math.nan])
@pytest.mark.parametrize("road", [("S", "A"), ("B", "G")])
def test_a_negative_cost_is_an_error(road: tuple[str, str], cost: float) -> None:
    problem = Travel(DETOUR | {road: cost}, "S", "G")
    for search in (uniform_cost_search, lambda problem: astar_search(problem, zero)):
        with pytest.raises(ValueError, match=f"'{road[1]}' in '{road[0]}' costs {cost}; at least"):
            search(problem)
    is_lost_in_rounding = Travel({("S", "A"): 1e20, ("A", "G"): -1.0}, "S", "G")
    with pytest.raises(ValueError, match=r"'G' in 'A' costs -1\.0; at least 0"):
        uniform_cost_search(is_lost_in_rounding)


@pytest.mark.parametrize("weight", [-1e-9, math.nan])
def test_a_negative_weight_is_an_error(weight: float) -> None:
    with pytest.raises(ValueError, match=rf"weight is {weight}; it must be 0\.\.1000000 or inf"):
        weighted_astar_search(romania(), straight_line, weight)


def test_the_paths_of_all_algorithms_are_valid_and_as_short_as_they_promise() -> None:
    """Against networkx; some goals cannot be reached."""
    stream = random.Random(4)
    unreachable = dearer = 0
    for _ in range(ROUTES):
        rows, problem = random_route(stream)
        estimate, graph = manhattan(problem), route_graph(rows)
        shortest = (
            breadth_first_search(problem),
            uniform_cost_search(problem),
            astar_search(problem, estimate),
        )
        greedy = greedy_best_first_search(problem, estimate)
        by_weight = {
            weight: weighted_astar_search(problem, estimate, weight) for weight in (0.5, 1.5, 3.0)
        }
        solutions = *shortest, greedy, *by_weight.values()
        if not nx.has_path(graph, problem.initial, problem.goal):
            unreachable += 1
            assert not any(found.found for found in solutions)
            continue
        least = nx.shortest_path_length(graph, problem.initial, problem.goal)
        assert [found.cost for found in shortest] == [least] * 3
        for weight, found in by_weight.items():
            assert least <= found.cost <= max(weight, 1.0) * least
            dearer += least < found.cost
        for found in solutions:
            done = replay_route(rows, problem.initial, problem.goal, found.actions)
            assert done.errors == []
            assert (done.cost, tuple(done.places)) == (found.cost, found.states)
    assert ROUTES / 10 < unreachable < ROUTES / 2
    assert dearer, "every path was optimal"


def test_an_admissible_but_inconsistent_heuristic_still_finds_the_best_path() -> None:
    """B is reached by the long road first and expanded twice, so the better path is found."""
    estimates = {"S": 0, "A": 11, "B": 0, "C": 0, "G": 0}
    found = astar_search(Travel(DETOUR, "S", "G"), estimates.__getitem__, with_events=True)
    assert expanded(found) == ["S", "B", "A", "C", "B"]
    assert (found.states, found.cost) == (("S", "A", "B", "G"), 12)


def test_without_reopening_the_first_path_to_an_expanded_state_is_kept() -> None:
    """B keeps the long road by which it was expanded, and no state is expanded again."""
    estimates = {"S": 0, "A": 11, "B": 0, "C": 0, "G": 0}
    for weight in (1.0, 2.0):
        found = weighted_astar_search(
            Travel(DETOUR, "S", "G"), estimates.__getitem__, weight, with_events=True, reopen=False
        )
        assert expanded(found) == ["S", "B", "A", "C"][: 4 if weight == 1 else 2]
        assert (found.states, found.cost) == (("S", "B", "G"), 15)


def test_greedy_search_expands_no_state_twice_unless_it_reopens() -> None:
    """An open floor with a goal enclosed by walls: all other cells are expanded once."""
    rows = ["." * 30 for _ in range(30)]
    rows[14] = rows[16] = "." * 14 + "###" + "." * 13
    rows[15] = "." * 14 + "#.#" + "." * 13
    problem = RouteProblem(Layout(rows), (0, 0), (15, 15))
    once = greedy_best_first_search(problem, manhattan(problem), with_events=True)
    assert once.expanded == len(set(expanded(once))) == 30 * 30 - 9
    often = greedy_best_first_search(problem, manhattan(problem), reopen=True)
    assert often.expanded > 2 * once.expanded
    assert not once.found
    assert not often.found
