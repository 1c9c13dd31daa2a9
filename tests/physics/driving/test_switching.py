"""Who passes first after a delay: all orders stay free of circles, and robots arrive sooner."""

import itertools
import random

import numpy as np
import pytest
from helpers.driving import resolved
from scipy.optimize import LinearConstraint, milp

from agents.mapf.execution import drive_through
from warehouse_core import Cell, Layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop
from warehouse_physics.driving import switching
from warehouse_physics.driving.dependencies import Dependencies, Visit
from warehouse_physics.driving.switching import Progress, Timetable, find_switches

FAST = RobotSpec.fast()
Plan = list[list[Cell]]

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


def at_starts(robots: int, late: int = 0, seconds: float = 60.0) -> Progress:
    """Return robots at rest at their starts, of which one is late."""
    starts = np.where(np.arange(robots) == late, seconds, 0.0)
    return Progress(*([0] * robots for _ in range(3)), starts, 1.0)


def random_plan(seed: int, robots: int, steps: int, side: int) -> Plan:
    stream, layout = random.Random(seed), Layout(["." * side] * side)
    cells = [divmod(int(cell), side) for cell in layout.open_cells]
    actions = [[stream.randrange(5) for _ in range(robots)] for _ in range(steps)]
    return resolved(layout, stream.sample(cells, robots), actions)


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


def switch(ways: Dependencies, progress: Progress) -> set[int]:
    return {
        robot for order in find_switches(ways, progress).values() for robot in ways.reorder(order)
    }


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


def optimum(plan: Plan, progress: Progress) -> float:
    """Return the least sum of arrivals over all orders of visits, by mixed-integer programming."""
    ways, robots = built(plan), len(plan[0])
    visits = [Visit(robot, each) for robot in range(robots) for each in range(ways.last(robot) + 1)]
    place = {visit: at for at, visit in enumerate(visits)}
    pairs = [
        (one, two)
        for one, two in itertools.combinations(visits, 2)
        if one.robot != two.robot and ways.node(*one).cell == ways.node(*two).cell
    ]
    count, large, rows = len(visits) + len(pairs), 1e3, []

    def later(one: Visit, two: Visit, by: float, choice: int = -1, sign: float = 0.0) -> None:
        row = np.zeros(count)
        row[place[one]], row[place[two]] = -1.0, 1.0
        if choice >= 0:
            row[choice] = sign * large
        rows.append((row, by - large * (sign < 0)))

    for visit in visits:
        if visit.number:
            later(Visit(visit.robot, visit.number - 1), visit, progress.pace)
    for at, (one, two) in enumerate(pairs, len(visits)):
        for first, second, sign in ((one, two, 1.0), (two, one, -1.0)):
            if first.number == ways.last(first.robot):  # it stays: the other one goes first
                row = np.zeros(count)
                row[at] = sign
                rows.append((row, float(sign > 0)))
            else:
                leaves = Visit(first.robot, first.number + 1)
                later(leaves, second, 0.0, at, sign)
        if (swap := (Visit(one.robot, one.number + 1), Visit(two.robot, two.number - 1))) in pairs:
            row = np.zeros(count)
            row[at], row[len(visits) + pairs.index(swap)] = 1.0, -1.0  # nobody changes places
            rows += [(row, 0.0), (-row, 0.0)]
    costs = np.zeros(count)
    lowest, highest = np.zeros(count), np.full(count, np.inf)
    highest[len(visits) :] = 1.0
    for robot in range(robots):
        costs[place[Visit(robot, ways.last(robot))]] = 1.0
        lowest[place[Visit(robot, 0)]] = progress.starts[robot]
    matrix, bounds = np.array([row for row, _ in rows]), np.array([by for _, by in rows])
    found = milp(
        costs,
        constraints=LinearConstraint(matrix, bounds),
        bounds=(lowest, highest),
        integrality=np.arange(count) >= len(visits),
    )
    assert found.success
    return float(found.fun)


def arrivals(ways: Dependencies, progress: Progress) -> float:
    table = Timetable(ways, progress)
    ends = {visit.robot: time for visit, time in zip(table.visits, table.times(), strict=True)}
    return sum(ends.get(robot, start) for robot, start in enumerate(progress.starts.tolist()))


def test_the_search_wins_back_half_of_what_the_best_order_does() -> None:
    gained = possible = 0.0
    for seed in range(8):
        plan, progress = random_plan(seed, 4, 8, 3), at_starts(4, seed % 4, 20.0)
        ways = built(plan)
        before, best = arrivals(ways, progress), optimum(plan, progress)
        switch(ways, progress)
        after = arrivals(ways, progress)
        assert best <= after + 1e-6
        gained, possible = gained + before - after, possible + before - best
    assert possible > 20
    assert gained >= 0.5 * possible


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
