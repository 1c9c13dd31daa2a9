import random

import networkx as nx
import pytest
from helpers.plan_validator import open_places, random_rows, replay_route, route_graph

from agents.search.algorithms import astar_search, uniform_cost_search
from agents.search.heuristics import manhattan
from agents.search.problems import RouteProblem
from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError

LAYOUTS = 3_000
"""Beside the 10,000 with random costs in ``test_delivery_problem.py``."""


def test_routes_are_as_long_as_networkx_says() -> None:
    stream = random.Random(10)
    nowhere = 0
    for _ in range(LAYOUTS):
        rows = random_rows(stream)
        start, goal = (stream.choice(open_places(rows)) for _ in range(2))
        problem = RouteProblem(Layout(rows), start, goal)
        found = astar_search(problem, manhattan(problem))
        try:
            cost = nx.shortest_path_length(route_graph(rows), start, goal)
        except nx.NetworkXNoPath:
            nowhere += 1
            assert not found.found
            continue
        done = replay_route(rows, start, goal, found.actions)
        assert done.errors == []
        assert found.cost == uniform_cost_search(problem).cost == done.cost == cost
    assert LAYOUTS / 10 < nowhere < LAYOUTS / 2


def test_what_expansion_gives_is_what_the_problem_says_piece_by_piece() -> None:
    stream = random.Random(11)
    for _ in range(100):
        rows = random_rows(stream)
        places = open_places(rows)
        problem = RouteProblem(Layout(rows), places[0], places[-1])
        for place in places:
            moves = list(problem.expand(place))
            assert [move for move, _, _ in moves] == list(problem.actions(place))
            for move, successor, cost in moves:
                assert problem.result(place, move) == successor
                assert problem.action_cost(place, move, successor) == cost == 1


def test_the_goal_is_one_cell() -> None:
    problem = RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 6))
    assert problem.initial == (1, 1)
    assert [cell for cell in open_places(DEFAULT_LAYOUT.rows) if problem.is_goal(cell)] == [(5, 6)]


@pytest.mark.parametrize(
    ("start", "goal", "message"),
    [
        ((0, 0), (1, 1), r"start row 0, column 0 is wall; it must be an open cell"),
        ((1, 1), (2, 3), r"goal row 2, column 3 is wall; it must be an open cell"),
        ((1, 1), (7, 0), r"goal row 7, column 0 is off the grid \(rows 0..6, columns 0..11\)"),
        ((-1, -1), (1, 1), r"start row -1, column -1 is off the grid"),
    ],
)
def test_a_start_or_a_goal_that_is_not_open_is_refused(
    start: tuple[int, int], goal: tuple[int, int], message: str
) -> None:
    with pytest.raises(LayoutError, match=message):
        RouteProblem(DEFAULT_LAYOUT, start, goal)
