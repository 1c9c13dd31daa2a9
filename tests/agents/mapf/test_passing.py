"""The order in which robots pass the cells of a joint plan."""

import numpy as np

from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.passing import PassingOrder
from agents.mapf.planner import NO_CELLS, Situation, check_step
from agents.mapf.windows import WindowedPlanner
from warehouse_core import shelf_layout

CROSSING = np.array([[3, 4, 5, 5], [1, 1, 4, 7]])
RING = np.array([[0, 1], [1, 3], [2, 0], [3, 2]])


def test_a_robot_waits_for_one_that_is_to_pass_before_it_however_late_that_is() -> None:
    order = PassingOrder(CROSSING)
    assert order.movers([1]) == [], "the first is to pass the cell, and has not been in it"
    order.move(order.movers([0]))
    assert order.movers([1]) == [], "the first is in it"
    assert order.movers([0, 1]) == [0, 1], "the second follows"
    order.move([0])
    assert order.movers([1]) == [1], "who waits for nobody does not wait for its time"


def test_robots_in_a_ring_move_together_or_not_at_all() -> None:
    order = PassingOrder(RING)
    assert order.movers([0, 1, 2]) == []
    order.move(order.movers(range(4)))
    assert order.cells() == [1, 3, 0, 2]


def test_a_plan_that_goes_on_has_the_same_ways_without_conflicts() -> None:
    graph = Graph(shelf_layout(2, 3, aisle=1, pickups=4, dropoffs=2, seed=1))
    cells = run_lifelong(graph, WindowedPlanner(graph, seed=1), 20, 40, 1).cells.T
    order, stream = PassingOrder(cells), np.random.default_rng(1)
    nobody = np.zeros(20, np.bool_)
    for _ in range(30):  # some robots are late
        before = np.array(order.cells())
        order.move(order.movers(np.flatnonzero(stream.random(20) < 0.5).tolist()))
        check_step(graph, Situation(before, before, nobody, NO_CELLS), np.array(order.cells()))
    plan = order.plan(60, late=[3])
    assert plan[3, 1] == plan[3, 0] == order.cells()[3]
    for before, after in zip(plan.T[:-1], plan.T[1:], strict=True):
        check_step(graph, Situation(before, before, nobody, NO_CELLS), after)
    assert (plan[:, -1] == cells[:, -1]).all(), "all robots get to the ends of their ways"
