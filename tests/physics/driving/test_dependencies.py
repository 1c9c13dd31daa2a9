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
    found = Dependencies(plan[0])
    for before, cells in itertools.pairwise(plan):
        movers = [robot for robot, cell in enumerate(cells) if cell != before[robot]]
        assert found.extend(cells) == movers
    return found


def nodes_of(plan: Plan) -> list[list[RouteCell]]:
    """Return the nodes of each robot, from the order in which robots enter each cell."""
    ways: list[list[RouteCell]] = [[] for _ in plan[0]]
    entries: dict[Cell, list[Visit]] = {}
    for step, cells in enumerate(plan):
        for robot, cell in enumerate(cells):
            if step and cell == plan[step - 1][robot]:
                continue
            earlier = entries.setdefault(cell, [])
            others = earlier and earlier[-1].robot != robot
            ways[robot].append(RouteCell(cell, (earlier[-1],) if others else ()))
            earlier.append(Visit(robot, len(ways[robot]) - 1))
    return ways


@pytest.mark.parametrize("seed", range(4))
def test_a_robot_enters_a_cell_after_the_last_other_one_that_the_plan_has_there(seed: int) -> None:
    plan = random_plan(seed)[1]
    found, expected = build(plan), nodes_of(plan)
    assert sum(bool(node.after) for way in expected for node in way) > 10
    for robot, way in enumerate(expected):
        assert (found.last(robot), found.end(robot)) == (len(way) - 1, way[-1].cell)
        assert [found.node(robot, number) for number in range(len(way))] == way
        assert list(found.nodes(robot, 0)) == [*enumerate(way)][1:]
        assert list(found.nodes(robot, 3)) == [*enumerate(way)][3:]
        for number in range(1, len(way)):
            (row, col), move = way[number - 1].cell, found.move(robot, number)
            assert (row + move[0], col + move[1]) == way[number].cell


def test_nodes_that_are_forgotten_or_not_there_yet_raise() -> None:
    found = build([[(0, col)] for col in range(HISTORY + 6)])
    found.forget(0, HISTORY + 3)
    found.forget(0, HISTORY + 2)
    assert found.node(0, 3).cell == (0, 3)
    last = HISTORY + 5
    assert [number for number, _ in found.nodes(0, 0)] == list(range(4, last + 1))
    for number in (-1, 0, 2, last + 1):
        with pytest.raises(LookupError, match=f"no node {number}; its nodes are 3 to {last}"):
            found.node(0, number)
    with pytest.raises(LookupError, match="no node 2"):
        found.move(0, 3)


def test_a_cell_whose_last_visit_is_forgotten_has_no_order_any_more() -> None:
    long_row = [[(0, col), (1, 0)] for col in range(HISTORY + 2)]
    found = build(long_row)
    found.forget(0, HISTORY + 1)
    found.extend([(0, HISTORY + 1), (0, 0)])
    assert found.node(1, 1) == RouteCell((0, 0))
    found.extend([(0, HISTORY + 1), (0, 1)])
    assert found.node(1, 2) == RouteCell((0, 1), (Visit(0, 1),))


def test_a_cell_is_entered_after_its_robot_and_one_that_reaches_into_it_and_goes_back() -> None:
    """Robot 2 fails in front of robot 1, which stays; robot 0 has already begun to follow it."""
    found = build([[(0, 0), (0, 1), (0, 2), (1, 0)], [(0, 1), (0, 2), (0, 3), (1, 0)]])
    assert found.cut(2, 0, reached=[1, 0, 0, 0], present=[0, 0, 0, 0]) == {0: True, 1: False}
    assert [found.end(robot) for robot in range(3)] == [(0, 0), (0, 1), (0, 2)]
    found.extend([(0, 0), (1, 1), (0, 2), (1, 0)])
    found.extend([(0, 0), (1, 2), (0, 2), (1, 1)])
    found.extend([(0, 0), (1, 2), (0, 2), (0, 1)])
    assert found.node(3, 2).after == (Visit(0, 1), Visit(1, 0))
    leaders = Leaders(RobotSpec(), found, Limits(RobotSpec(), 4, Disturbances(grip=1.0)))
    assert leaders.nodes.shape == (4, 2)
    leaders.find(3, np.zeros(4))
    assert sorted(leaders.nodes[3].tolist()) == [1, 2, 2]
    leaders.drop(np.array([2.0, 0.0, 0.0, 0.0]))
    assert sorted(leaders.nodes[3].tolist()) == [1, 2, NOWHERE]


def test_a_cell_that_a_robot_has_not_left_has_an_order_after_another_one_has_failed() -> None:
    found = build([[(0, 0), (0, 1), (2, 5)], [(0, 0), (0, 2), (2, 5)], [(0, 0), (0, 3), (2, 5)]])
    assert found.cut(2, 0, reached=[0, 2, 0], present=[0, 0, 0]) == {}
    found.extend([(0, 1), (0, 3), (2, 5)])
    assert found.node(0, 1).after == (Visit(1, 0),)
