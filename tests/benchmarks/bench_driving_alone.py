"""Robots that drive their ways alone on the floor, over the fastest that force and speed allow.

The bound drives along straight lines between the middles of cells, and round each corner on a
quarter circle from edge to edge of its cell. On the circle it has the highest constant speed whose
centripetal acceleration is that of the robot. On the lines it accelerates and brakes as hard as the
robot can, up to the top speed. It stops only where a way turns back or ends. Robots may be faster
where they cut a corner along another curve.
"""

import math
from itertools import groupby, pairwise

import numpy as np
import pytest
from helpers.driving_validator import Place, ways_of

from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.registry import make_planner
from warehouse_core import Layout
from warehouse_core.world.generators import kiva_warehouse
from warehouse_physics import DrivingMotion, RobotSpec

ROBOTS, STEPS = 32, 100
LAYOUT, STARTS, GOALS = kiva_warehouse()
SPECS = {
    "default robots": RobotSpec(),
    "fast robots": RobotSpec(top_speed=2.0, acceleration=1.0),
    "slow robots": RobotSpec(top_speed=1.0, acceleration=0.5),
}
MAX_RATIO = 1.06
SPELL, MOVES = 5.0, 1e-5
"""Seconds of a spell, and metres in a substep that are a move."""


def bound(way: list[Place], spec: RobotSpec) -> float:
    """Return the seconds that the fastest robot needs for the cells of a way."""
    rate, half = spec.acceleration, spec.cell_size / 2
    corner_speed = min(spec.top_speed, math.sqrt(rate * half))
    runs = [
        (move, spec.cell_size * len(list(same)))
        for move, same in groupby((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(way))
    ]
    seconds, before, cut = 0.0, 0.0, 0.0
    for (move, length), (after, _) in pairwise([*runs, ((0, 0), 0.0)]):
        is_corner = any(after) and (move[0] + after[0], move[1] + after[1]) != (0, 0)
        speed, left = (corner_speed, half) if is_corner else (0.0, 0.0)
        seconds += seconds_on_line(length - cut - left, before, speed, spec)
        seconds += math.pi / 2 * half / corner_speed if is_corner else 0.0
        before, cut = speed, left
    return seconds


def seconds_on_line(length: float, before: float, after: float, spec: RobotSpec) -> float:
    """Return the least seconds over a length in metres, between two speeds in m/s."""
    rate = spec.acceleration
    peak = min(spec.top_speed, math.sqrt(rate * length + (before**2 + after**2) / 2))
    at_peak = length - (2 * peak**2 - before**2 - after**2) / (2 * rate)
    return (2 * peak - before - after) / rate + max(at_peak, 0.0) / peak


def arrivals(ways: list[list[Place]], spec: RobotSpec) -> np.ndarray:
    """Return the seconds in which each robot drives its way, on an empty floor of its own."""
    height, steps = LAYOUT.height, max(map(len, ways))
    motion = DrivingMotion(spec, path_every=1)
    joint = [
        [(robot * height + row, col) for robot, (row, col) in enumerate(cells)]
        for cells in zip(*([*way, *[way[-1]] * (steps - len(way))] for way in ways), strict=True)
    ]
    motion.reset(Layout(["." * LAYOUT.width] * (height * len(ways))), joint[0], 0)
    for cells in joint[1:]:
        motion.extend(cells)
    found, now = np.zeros(len(ways)), 0.0
    while not all(motion.ways().at_rest):
        for robot, outcome in enumerate(motion.drive(SPELL)):
            clock, moved = outcome.path[1:, 0], np.abs(np.diff(outcome.path[:, 1:3], axis=0))
            if len(times := clock[moved.max(axis=1) > MOVES]):
                found[robot] = now + times[-1]
        now += SPELL
    return found


@pytest.mark.parametrize("planner", ["pibt", "windowed", "pibt-lanes"])
@pytest.mark.parametrize("kind", SPECS)
def test_robots_alone_are_nearly_as_fast_as_force_and_speed_allow(
    planner: str, kind: str, measured
) -> None:
    mover = make_planner(planner, 0, LAYOUT, ROBOTS)
    run = run_lifelong(Graph(LAYOUT), mover, ROBOTS, STEPS, 0, STARTS, GOALS)
    ways = ways_of([LAYOUT.cells(cells) for cells in run.cells])
    least = np.array([bound(way, SPECS[kind]) for way in ways])
    driven = arrivals(ways, SPECS[kind])
    ratios = driven[least > 0] / least[least > 0]
    measured(
        f"{ROBOTS} ways of {planner} driven alone, {kind}",
        f"{driven.max() / least.max():.3f} of the bound by the last arrival, "
        f"{driven.sum() / least.sum():.3f} by the mean of all, at most {ratios.max():.3f}",
    )
    assert ratios.max() <= MAX_RATIO
