"""The order in which robots pass cells, compared with the joint plan that it is built from."""

import itertools
import random

import numpy as np
import pytest
from helpers.driving import resolved

from warehouse_core import Cell, Layout, random_layout
from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.driving.dependencies import HISTORY, Dependencies, RouteCell, Visit
from warehouse_physics.driving.leaders import NOWHERE, Leaders
from warehouse_physics.driving.limits import Limits

Plan = list[list[Cell]]


def random_plan(seed: int) -> tuple[Layout, Plan]:
    layout, stream = random_layout(7, 8, 0.2, seed=seed), random.Random(seed)
    cells = [divmod(int(cell), layout.width) for cell in layout.open_cells]
    starts = stream.sample(cells, len(cells) // 4)
    actions = [[stream.randrange(5) for _ in starts] for _ in range(80)]
    return layout, resolved(layout, starts, actions)


def build(plan: Plan) -> Dependencies:
    dependencies = Dependencies(plan[0])
    for before, cells in itertools.pairwise(plan):
        movers = [robot for robot, cell in enumerate(cells) if cell != before[robot]]
        assert dependencies.extend(cells) == movers
    return dependencies


def nodes_of(plan: Plan) -> list[list[RouteCell]]:
    """Return the nodes of each robot, from the order in which robots enter each cell."""
    routes: list[list[RouteCell]] = [[] for _ in plan[0]]
    entries: dict[Cell, list[Visit]] = {}
    for step, cells in enumerate(plan):
        for robot, cell in enumerate(cells):
            if step and cell == plan[step - 1][robot]:
                continue
            earlier = entries.setdefault(cell, [])
            others = earlier and earlier[-1].robot != robot
            routes[robot].append(RouteCell(cell, (earlier[-1],) if others else ()))
            earlier.append(Visit(robot, len(routes[robot]) - 1))
    return routes


@pytest.mark.parametrize("seed", range(4))
def test_a_robot_enters_a_cell_after_the_last_other_one_that_the_plan_has_there(seed: int) -> None:
    plan = random_plan(seed)[1]
    dependencies, expected = build(plan), nodes_of(plan)
    assert sum(bool(node.after) for route in expected for node in route) > 10
    for robot, route in enumerate(expected):
        assert (dependencies.last(robot), dependencies.end(robot)) == (
            len(route) - 1,
            route[-1].cell,
        )
        assert [dependencies.node(robot, number) for number in range(len(route))] == route
        assert list(dependencies.nodes(robot, 0)) == [*enumerate(route)][1:]
        assert list(dependencies.nodes(robot, 3)) == [*enumerate(route)][3:]
        for number in range(1, len(route)):
            (row, col), move = route[number - 1].cell, dependencies.move(robot, number)
            assert (row + move[0], col + move[1]) == route[number].cell


def test_nodes_that_are_forgotten_or_not_there_yet_raise() -> None:
    dependencies = build([[(0, col)] for col in range(HISTORY + 6)])
    dependencies.forget(0, HISTORY + 3)
    dependencies.forget(0, HISTORY + 2)
    assert dependencies.node(0, 3).cell == (0, 3)
    last = HISTORY + 5
    assert [number for number, _ in dependencies.nodes(0, 0)] == list(range(4, last + 1))
    for number in (-1, 0, 2, last + 1):
        with pytest.raises(LookupError, match=f"no node {number}; its nodes are 3 to {last}"):
            dependencies.node(0, number)
    with pytest.raises(LookupError, match="no node 2"):
        dependencies.move(0, 3)


def test_a_cell_whose_last_visit_is_forgotten_has_no_order_any_more() -> None:
    long_row = [[(0, col), (1, 0)] for col in range(HISTORY + 2)]
    dependencies = build(long_row)
    dependencies.forget(0, HISTORY + 1)
    dependencies.extend([(0, HISTORY + 1), (0, 0)])
    assert dependencies.node(1, 1) == RouteCell((0, 0))
    dependencies.extend([(0, HISTORY + 1), (0, 1)])
    assert dependencies.node(1, 2) == RouteCell((0, 1), (Visit(0, 1),))


def test_a_cell_is_entered_after_its_robot_and_one_that_reaches_into_it_and_goes_back() -> None:
    """Robot 2 fails in front of robot 1, which stays; robot 0 has already begun to follow it."""
    dependencies = build([[(0, 0), (0, 1), (0, 2), (1, 0)], [(0, 1), (0, 2), (0, 3), (1, 0)]])
    assert dependencies.cut(2, 0, reached=[1, 0, 0, 0], present=[0, 0, 0, 0]) == {0: True, 1: False}
    assert [dependencies.end(robot) for robot in range(3)] == [(0, 0), (0, 1), (0, 2)]
    dependencies.extend([(0, 0), (1, 1), (0, 2), (1, 0)])
    dependencies.extend([(0, 0), (1, 2), (0, 2), (1, 1)])
    dependencies.extend([(0, 0), (1, 2), (0, 2), (0, 1)])
    assert dependencies.node(3, 2).after == (Visit(0, 1), Visit(1, 0))
    leaders = Leaders(RobotSpec(), dependencies, Limits(RobotSpec(), 4, Disturbances(grip=1.0)))
    assert leaders.nodes.shape == (4, 2)
    leaders.find(3, np.zeros(4))
    assert sorted(leaders.nodes[3].tolist()) == [1, 2, 2]
    leaders.drop(np.array([2.0, 0.0, 0.0, 0.0]))
    assert sorted(leaders.nodes[3].tolist()) == [1, 2, NOWHERE]


def test_a_cell_that_a_robot_has_not_left_has_an_order_after_another_one_has_failed() -> None:
    dependencies = build(
        [[(0, 0), (0, 1), (2, 5)], [(0, 0), (0, 2), (2, 5)], [(0, 0), (0, 3), (2, 5)]]
    )
    assert dependencies.cut(2, 0, reached=[0, 2, 0], present=[0, 0, 0]) == {}
    dependencies.extend([(0, 1), (0, 3), (2, 5)])
    assert dependencies.node(0, 1).after == (Visit(1, 0),)
