"""Small plans with a robot that is late, and the best order of passing, by HiGHS."""

import itertools
import random

import numpy as np
from scipy.optimize import LinearConstraint, milp

from helpers.driving import resolved
from warehouse_core import Cell, Layout
from warehouse_physics.driving.dependencies import Dependencies, Visit
from warehouse_physics.driving.switching import RouteProgress, Timetable, find_switches

Plan = list[list[Cell]]


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


def optimum(plan: Plan, progress: RouteProgress) -> float:
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
    for at, (one, two) in enumerate(pairs, len(visits)):  # a robot is in its first cell already
        lowest[at], highest[at] = float(two.number == 0), float(one.number > 0)
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


def arrivals(ways: Dependencies, progress: RouteProgress) -> float:
    table = Timetable(ways, progress)
    ends = {visit.robot: time for visit, time in zip(table.visits, table.times(), strict=True)}
    return sum(ends.get(robot, start) for robot, start in enumerate(progress.starts.tolist()))


def on_small_plan(seed: int) -> tuple[float, float, float]:
    """Return the sums of arrivals of four robots, of which one is 20 s late.

    They are those in the order of the plan, in the order that the search finds, and in the best.
    """
    plan, progress = random_plan(seed, 4, 8, 3), at_starts(4, seed % 4, 20.0)
    ways = built(plan)
    before, best = arrivals(ways, progress), optimum(plan, progress)
    switch(ways, progress)
    return before, arrivals(ways, progress), best
