"""Heuristics compared with exact costs from networkx."""

import math
import random
from collections.abc import Iterable

import networkx as nx
from helpers.plan_validator import (
    END,
    delivery_graph,
    open_places,
    random_prices,
    random_rows,
    route_graph,
)

from agents.search.costs import ActionCosts
from agents.search.heuristics import (
    MAX_COMPARED,
    manhattan,
    manhattan_delivery,
    true_distance,
    zero,
)
from agents.search.problems import DELIVERED, DeliveryProblem, RouteProblem
from warehouse_core import Cell, Layout

LAYOUTS = 40


def steps_to(here: Cell, cells: Iterable[Cell]) -> int:
    return min(abs(here[0] - row) + abs(here[1] - col) for row, col in cells)


def test_heuristics_of_routes_never_overestimate_and_are_consistent() -> None:
    stream = random.Random(30)
    for _ in range(LAYOUTS):
        rows = random_rows(stream)
        places = open_places(rows)
        goal, layout = stream.choice(places), Layout(rows)
        problem = RouteProblem(layout, places[0], goal)
        graph = route_graph(rows)
        true = nx.single_source_shortest_path_length(graph, goal)
        without_walls, exact = manhattan(problem), true_distance(problem, layout)
        for place in places:
            assert without_walls(place) == abs(place[0] - goal[0]) + abs(place[1] - goal[1])
            assert without_walls(place) <= exact(place) == true.get(place, math.inf)
            assert zero(place) == 0
        for estimate in (zero, without_walls, exact):
            assert estimate(goal) == 0
            for here, there in graph.edges:
                assert estimate(here) <= 1 + estimate(there)
                assert estimate(there) <= 1 + estimate(here)


def test_heuristics_of_deliveries_never_overestimate_and_are_consistent() -> None:
    """With random prices, including 0, and zero to three stations of each kind."""
    stream = random.Random(31)
    for _ in range(LAYOUTS):
        rows, prices = random_rows(stream), random_prices(stream)
        places = open_places(rows)
        pickups, dropoffs = (
            stream.sample(places, min(stream.choice((0, 1, 2, 3)), len(places))) for _ in range(2)
        )
        graph = delivery_graph(rows, pickups, dropoffs, prices)
        true = nx.single_source_dijkstra_path_length(graph.reverse(copy=False), END)
        costs = ActionCosts(*prices)
        problem = DeliveryProblem(
            Layout(rows), places[0], pickups=pickups, dropoffs=dropoffs, costs=costs
        )
        without_walls = manhattan_delivery(problem)
        states = {way: DELIVERED if way == END else way for way in graph}
        for way, state in states.items():
            assert without_walls(state) <= true.get(way, math.inf)
        assert without_walls(DELIVERED) == zero(DELIVERED) == 0
        for estimate in (zero, without_walls):
            for here, there, price in graph.edges.data("weight"):
                assert estimate(states[here]) <= price + estimate(states[there])


def test_with_many_stations_the_estimate_is_the_least_over_all_pairs() -> None:
    """Also with more stations than are compared one by one, for random shapes and prices."""
    stream = random.Random(33)
    for _ in range(20):
        height, width = stream.randint(2, 12), stream.randint(12, 20)
        cells = [(row, col) for row in range(height) for col in range(width)]
        pickups, dropoffs = (
            stream.sample(cells, stream.choice((1, MAX_COMPARED, MAX_COMPARED + 1, 20)))
            for _ in range(2)
        )
        costs = ActionCosts(*random_prices(stream))
        problem = DeliveryProblem(
            Layout(["." * width] * height), (0, 0), pickups=pickups, dropoffs=dropoffs, costs=costs
        )
        estimate = manhattan_delivery(problem)
        for cell in cells:
            last = {there: steps_to(there, dropoffs) for there in [*pickups, cell]}
            assert estimate((*cell, True)) == costs.move_loaded * last[cell] + costs.drop
            assert estimate((*cell, False)) == costs.pick + costs.drop + min(
                costs.move_empty * steps_to(cell, [there]) + costs.move_loaded * last[there]
                for there in pickups
            )
