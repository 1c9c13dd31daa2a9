"""Routes and deliveries, compared with networkx and checked by a plan validator."""

import random
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import networkx as nx
import pytest
from helpers.plan_validator import (
    END,
    Place,
    Prices,
    Replay,
    delivery_graph,
    open_places,
    random_prices,
    random_rows,
    replay_delivery,
)

from agents.search.algorithms import astar_search, breadth_first_search, uniform_cost_search
from agents.search.costs import ActionCosts
from agents.search.heuristics import manhattan_delivery
from agents.search.problems import DELIVERED, DeliveryProblem, RouteProblem, move_table
from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError, WarehouseEnv
from warehouse_core.task.rules import useful_actions
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.generators import random_layout

DELIVERIES = 200


# The move table.


def test_the_moves_from_a_cell_lead_to_the_open_cells_beside_it() -> None:
    table = move_table(Layout(["..#", ".P.", "#.D"]))
    assert not table, "nothing is computed before it is looked up"
    assert table[1, 1] == (
        ("N", (0, 1), 1.0), ("E", (1, 2), 1.0), ("S", (2, 1), 1.0), ("W", (1, 0), 1.0),
    )  # fmt: skip
    assert table[0, 0] == (("E", (0, 1), 1.0), ("S", (1, 0), 1.0)), "an edge is north and west"
    assert table[2, 2] == (("N", (1, 2), 1.0), ("W", (2, 1), 1.0)), "an edge is south and east"
    assert table.keys() == {(1, 1), (0, 0), (2, 2)}
    assert table[1, 1] is table[1, 1]


def test_layouts_with_the_same_walls_share_a_table_and_others_do_not() -> None:
    layout = random_layout(9, 9, 0.2, seed=1)
    cells = [layout.open_cell(index) for index in range(4)]
    table = move_table(layout)
    assert move_table(layout.with_stations(cells[0], cells[1])) is table
    assert move_table(layout.with_stations(cells[3], None)) is table
    assert move_table(Layout(["..#"]))[0, 1] == (("W", (0, 0), 1.0),)
    assert move_table(Layout(["#.."]))[0, 1] == (("E", (0, 2), 1.0),)
    assert move_table(Layout(["...", "..."]))[0, 2] == (("S", (1, 2), 1.0), ("W", (0, 1), 1.0))


# Deliveries.


class Case(NamedTuple):
    rows: list[str]
    start: Place
    has_item: bool
    pickups: list[Place]
    dropoffs: list[Place]
    prices: Prices

    @property
    def problem(self) -> DeliveryProblem:
        return DeliveryProblem(
            Layout(self.rows),
            self.start,
            self.has_item,
            pickups=self.pickups,
            dropoffs=self.dropoffs,
            costs=ActionCosts(*self.prices),
        )

    def replay(self, plan: tuple[str, ...]) -> Replay:
        _, start, has_item, pickups, dropoffs, prices = self
        return replay_delivery(self.rows, start, has_item, pickups, dropoffs, prices, plan)

    def graph(self) -> nx.DiGraph:
        return delivery_graph(self.rows, self.pickups, self.dropoffs, self.prices)


def random_cases(seed: int, count: int) -> Iterator[Case]:
    """Yield deliveries with up to three pickups and dropoffs, some cells of both kinds."""
    stream = random.Random(seed)
    for _ in range(count):
        rows = random_rows(stream)
        places = open_places(rows)
        pickups, dropoffs = (
            stream.sample(places, min(len(places), stream.choice((0, 1, 1, 1, 2, 2, 3, 3))))
            for _ in range(2)
        )
        has_item, start = stream.random() < 0.2, stream.choice(places)
        yield Case(rows, start, has_item, pickups, dropoffs, random_prices(stream))


def test_plans_have_the_cost_that_networkx_finds_or_the_fewest_actions() -> None:
    unreachable = dearer = 0
    for case in random_cases(20, DELIVERIES):
        problem, graph, ends = case.problem, case.graph(), ((*case.start, case.has_item), END)
        best = astar_search(problem, manhattan_delivery(problem))
        uniform, fewest = uniform_cost_search(problem), breadth_first_search(problem)
        if not nx.has_path(graph, *ends):
            unreachable += 1
            assert not any(found.found for found in (best, uniform, fewest))
            continue
        assert best.cost == uniform.cost == nx.dijkstra_path_length(graph, *ends)
        assert len(fewest.actions) == nx.shortest_path_length(graph, *ends)
        dearer += fewest.cost > best.cost
        for found in (best, uniform, fewest):
            done = case.replay(found.actions)
            assert (done.errors, done.cost) == ([], found.cost)
            assert done.places[:-1] == [(row, col) for row, col, _ in found.states[:-1]]
    assert DELIVERIES / 10 < unreachable < DELIVERIES / 2
    assert dearer, "the plan of the fewest actions was always the cheapest"


def test_the_transition_model_equals_that_of_the_environment() -> None:
    """Every state of a layout with two stations of each kind, every action with an effect."""
    layout = Layout(["P.#D", ".P..", "#.D.", "...."])
    env = WarehouseEnv(layout, start_pos=(0, 0), max_steps=10**6, battery=10**6)
    problem = DeliveryProblem(layout, (0, 0))
    for row, col in open_places(layout.rows):
        for has_item in (False, True):
            sides = layout.open_sides((row, col))
            useful = useful_actions(sides, layout.rows[row][col], has_item)
            words = {word for word, good in zip(ACTIONS, useful, strict=True) if good} - {"WAIT"}
            state = (row, col, has_item)
            assert set(problem.actions(state)) == words
            assert len(problem.expand(state)) == len(words)
            for word in words:
                env.state.robot_pos, env.state.has_item = (row, col), has_item
                _, _, terminated, _, _ = env.step(word)
                after = (*env.state.robot_pos, env.state.has_item)
                assert problem.result(state, word) == (DELIVERED if terminated else after)


def test_after_the_delivery_there_are_no_actions() -> None:
    problem = DeliveryProblem(DEFAULT_LAYOUT, (1, 1))
    assert problem.expand(DELIVERED) == problem.actions(DELIVERED) == []
    assert problem.is_goal(DELIVERED)
    cells = open_places(DEFAULT_LAYOUT.rows)
    assert not any(problem.is_goal((*cell, load)) for cell in cells for load in (False, True))


def test_the_stations_are_those_of_the_layout_unless_others_are_given() -> None:
    layout = Layout(["P....D"])
    assert uniform_cost_search(DeliveryProblem(layout, (0, 2))).cost == 2 + 1 + 5 + 1
    nearer = DeliveryProblem(layout, (0, 2), pickups=[(0, 3)])
    assert uniform_cost_search(nearer).actions == ("E", "PICK", "E", "E", "DROP")
    back = DeliveryProblem(layout, (0, 2), pickups=[(0, 3)], dropoffs=[(0, 1)])
    assert uniform_cost_search(back).actions == ("E", "PICK", "W", "W", "DROP")
    none = DeliveryProblem(layout, (0, 2), pickups=[])
    assert not uniform_cost_search(none).found, "an empty list is not replaced by the layout's"
    assert not uniform_cost_search(DeliveryProblem(layout, (0, 2), dropoffs=[])).found
    assert uniform_cost_search(DeliveryProblem(layout, (0, 2), True, pickups=[])).cost == 3 + 1


@pytest.mark.parametrize(
    ("kind", "cells", "words"),
    [
        (RouteProblem, {"start": (0, 0), "goal": (1, 1)}, "start row 0, column 0 is wall; it must"),
        (RouteProblem, {"start": (1, 1), "goal": (7, 0)}, "goal row 7, column 0 is off the grid ("),
        (DeliveryProblem, {"start": (0, 0)}, "start row 0, column 0 is wall; it must be an open"),
        (DeliveryProblem, {"start": (1, 1), "pickups": [(0, 1)]}, "pickup row 0, column 1 is wall"),
        (DeliveryProblem, {"start": (1, 1), "dropoffs": [(9, 9)]}, "dropoff row 9, column 9 is "),
    ],
)
def test_a_cell_that_is_not_open_is_an_error(kind: Any, cells: dict[str, Any], words: str) -> None:
    with pytest.raises(LayoutError, match=f"^{re.escape(words)}"):
        kind(DEFAULT_LAYOUT, **cells)
