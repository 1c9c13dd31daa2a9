"""Who passes first after a delay: all orders stay free of circles, and robots arrive sooner."""

import random

import numpy as np
import pytest
from helpers.driving import resolved

from agents.mapf.execution import drive_through
from warehouse_core import Cell, Layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop
from warehouse_physics.driving import switching
from warehouse_physics.driving.dependencies import Dependencies, Visit
from warehouse_physics.driving.switching import RouteProgress, Timetable, find_switches

Plan = list[list[Cell]]

FAST = RobotSpec.fast()

CROSSING: Plan = [
    [(2, 0), (0, 3)],
    [(2, 1), (0, 3)],
    [(2, 2), (0, 3)],
    [(2, 3), (1, 3)],
    [(2, 4), (1, 3)],
    [(2, 5), (2, 3)],
    [(2, 6), (3, 3)],
]
"""The first robot goes east, and the second one south through its way after it."""

LANE: Plan = [[(0, 0), (0, 4)], [(0, 1), (0, 4)], [(0, 2), (0, 4)], [(1, 2), (0, 4)]] + [
    [(2, 2), (0, col)] for col in (3, 2, 1, 0)
]
"""Robots that go through one lane in opposite directions, of which the first leaves it half way."""


def built(plan: Plan) -> Dependencies:
    ways = Dependencies(plan[0])
    for cells in plan[1:]:
        ways.extend(cells)
    return ways


def at_starts(robots: int, late: int = 0, seconds: float = 60.0) -> RouteProgress:
    """Return robots at rest at their starts, of which one is late."""
    starts = np.where(np.arange(robots) == late, seconds, 0.0)
    return RouteProgress(*([0] * robots for _ in range(3)), starts, 1.0)


def random_plan(seed: int, robots: int, steps: int, side: int) -> Plan:
    stream, layout = random.Random(seed), Layout(["." * side] * side)
    cells = [divmod(int(cell), side) for cell in layout.open_cells]
    actions = [[stream.randrange(5) for _ in range(robots)] for _ in range(steps)]
    return resolved(layout, stream.sample(cells, robots), actions)


def switch(ways: Dependencies, progress: RouteProgress) -> set[int]:
    return {
        robot for order in find_switches(ways, progress).values() for robot in ways.reorder(order)
    }


def is_driven_through(ways: Dependencies, robots: int) -> bool:
    """Return whether robots that move on when they may, also in rings, all come to their ends."""
    at = [0] * robots
    while True:
        movers = {robot for robot in range(robots) if at[robot] < ways.last(robot)}
        while True:  # those remain whose leaders have gone or go now
            stay = {
                robot
                for robot in movers
                for other, number in ways.node(robot, at[robot] + 1).after
                if at[other] < number or (at[other] == number and other not in movers)
            }
            if not stay:
                break
            movers -= stay
        if not movers:
            return all(at[robot] == ways.last(robot) for robot in range(robots))
        for robot in movers:
            at[robot] += 1
        taken = [ways.node(robot, number).cell for robot, number in enumerate(at)]
        assert len(set(taken)) == robots, "two robots are in one cell"


def test_a_robot_goes_first_that_would_wait_for_one_that_has_stopped() -> None:
    ways = built(CROSSING)
    assert switch(ways, at_starts(2)) == {0, 1}
    assert ways.node(1, 2).after == ()
    assert ways.node(0, 3).after == (Visit(1, 2),)
    ways = built(CROSSING)
    assert switch(ways, at_starts(2, late=1)) == set(), "the robot that is late is the second"


def test_all_cells_of_a_lane_are_switched_together() -> None:
    found = find_switches(built(LANE), at_starts(2))
    assert found == {}, "the first robot is in the cell where the other one wants to end"
    lane = [[(1, 0), (0, 4)], [(0, 0), (0, 4)], *LANE[1:-1]]
    ways = built([*lane, [(2, 2), (1, 1)]])
    assert switch(ways, at_starts(2)) == {0, 1}
    assert ways.node(0, 2).after == (Visit(1, 3),)
    assert is_driven_through(ways, 2)


@pytest.mark.parametrize("reached", [3, 4])
def test_nobody_is_let_through_where_a_robot_cannot_stop_any_more(reached: int) -> None:
    progress = at_starts(2)._replace(reached=[reached, 0])
    assert find_switches(built(CROSSING), progress) == {}
    assert find_switches(built(CROSSING), at_starts(2)._replace(reached=[2, 0]))


def test_a_search_ends_after_as_many_tries_as_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(switching, "MAX_TRIES", 0)
    assert find_switches(built(CROSSING), at_starts(2)) == {}


def test_nobody_is_put_off_until_after_one_that_has_committed_or_stays() -> None:
    ways = built(CROSSING)
    table = Timetable(ways, at_starts(2)._replace(reached=[0, 2]))
    assert table.let_through(Visit(0, 3), Visit(1, 2)) == {}
    table = Timetable(built(CROSSING[:-1]), at_starts(2))
    assert table.let_through(Visit(0, 3), Visit(1, 2)) == {}


def test_the_last_visit_of_a_cell_is_the_one_that_was_put_off() -> None:
    ways = built(CROSSING)
    switch(ways, at_starts(2))
    ways.extend([(2, 6), (3, 2)])
    ways.extend([(2, 6), (2, 2)])
    ways.extend([(2, 6), (2, 3)])
    assert ways.node(1, 6).after == (Visit(0, 3),)


@pytest.mark.parametrize("seed", range(30))
def test_random_plans_stay_free_of_circles_and_nobody_is_let_through_in_vain(seed: int) -> None:
    plan = random_plan(seed, 9, 30, 5)
    ways, progress = built(plan), at_starts(9, late=seed % 9)
    assert is_driven_through(ways, 9)
    table = Timetable(ways, progress)
    before = table.total(table.times())
    changed = switch(ways, progress)
    assert is_driven_through(ways, 9)
    table = Timetable(ways, progress)
    after = table.total(table.times())
    assert after < before - 0.5 if changed else after == before


@pytest.mark.parametrize("at", [0.0, 0.5])
def test_bodies_that_are_let_through_do_not_wait_for_one_that_has_stopped(at: float) -> None:
    layout, plan = Layout(["......."] * 4), np.array([[r * 7 + c for r, c in s] for s in CROSSING])
    stop = Disturbances(stops=(Stop(0, at, 20.0),))
    waits, passes = (drive_through(layout, plan, FAST, stop, switches=on) for on in (False, True))
    assert waits.arrivals[1] > 20 > 8 > passes.arrivals[1]
    assert waits.hits == passes.hits == 0
    assert passes.arrivals[0] == pytest.approx(waits.arrivals[0], abs=0.1)


def test_orders_stay_without_stops_before_them_and_after_a_failure() -> None:
    layout = Layout(["......."] * 4)
    for stops, fails in (((), False), ((Stop(0, 9.0, 5.0),), False), ((Stop(0, 0.5, 9.0),), True)):
        motion = DrivingMotion(FAST, Disturbances(stops=stops), path_every=1, switches=True)
        other = DrivingMotion(FAST, Disturbances(stops=stops), path_every=1)
        paths = []
        for each in (motion, other):
            each.reset(layout, [*CROSSING[0], (0, 0)], 0)
            for cells in CROSSING[1:]:
                each.extend([*cells, (0, 0)])
            if fails:
                each.fail(2)
            paths.append(np.stack([outcome.path for outcome in each.drive(8.0)]))
        assert np.array_equal(*paths)
