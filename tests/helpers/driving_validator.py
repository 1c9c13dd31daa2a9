"""A validator of robots that drive through a joint plan, which shares no code with the driver.

It knows the plan, and the position of each robot at each substep.
"""

import math
from collections.abc import Sequence
from itertools import combinations, groupby, pairwise

import numpy as np

from warehouse_physics import RobotSpec

Place = tuple[int, int]
Joint = Sequence[Sequence[Place]]
"""The cell of each robot before each joint step and after the last."""

SLACK = 1e-5
"""Share of a limit by which the solver may exceed it."""


def driving_fault(plan: Joint, positions: np.ndarray, spec: RobotSpec) -> str | None:
    """Return the first fault of ``R`` robots that have executed a plan, or ``None``.

    They were at ``positions``, ``[N, R, 2]`` metres, at each substep.
    """
    return (
        motion_fault(positions, spec)
        or _off_the_route(plan, positions, spec)
        or _out_of_order(plan, positions, spec)
    )


def motion_fault(positions: np.ndarray, spec: RobotSpec) -> str | None:
    """Return the first fault that needs no plan; for arguments see ``driving_fault``."""
    return too_near(positions, spec) or _too_fast(positions, spec)


def too_near(positions: np.ndarray, spec: RobotSpec) -> str | None:
    """Return the first two robots that come too close; for arguments see ``driving_fault``."""
    for one, other in combinations(range(positions.shape[1]), 2):
        apart = np.hypot(*(positions[:, one] - positions[:, other]).T)
        if apart.min() < 2 * spec.radius * (1 - SLACK):
            return f"robots {one} and {other} are {apart.min():.3f} m apart, at {apart.argmin()}"
    return None


def _too_fast(positions: np.ndarray, spec: RobotSpec) -> str | None:
    speeds = np.diff(positions, axis=0) / spec.time_step
    rates = np.diff(speeds, axis=0) / spec.time_step
    for name, values, limit in (
        ("drives at", speeds, spec.top_speed),
        ("speeds up or brakes by", rates, spec.acceleration),
    ):
        found = np.hypot(values[..., 0], values[..., 1])
        if found.max(initial=0.0) > limit * (1 + 100 * SLACK):
            substep, robot = np.unravel_index(found.argmax(), found.shape)
            return f"robot {robot} {name} {found.max():.4f}, at {substep}"
    return None


def _off_the_route(plan: Joint, positions: np.ndarray, spec: RobotSpec) -> str | None:
    room = spec.cell_size / 2 - spec.radius
    for robot, route in enumerate(routes_of(plan)):
        cells = [_cell(at, spec) for at in positions[:, robot]]
        visits = [cell for cell, _ in groupby(cells)]
        if visits != route:
            return f"robot {robot} is in {visits}, not in {route}"
        if math.dist(positions[-1, robot], _middle(route[-1], spec)) > 2e-3 * spec.cell_size:
            return f"robot {robot} ends at {positions[-1, robot]}, not in the middle of {route[-1]}"
        visit = -1
        for substep, (cell, places) in enumerate(zip([None, *cells], cells, strict=False)):
            visit += cell != places
            near = [_middle(each, spec) for each in route[max(visit - 1, 0) : visit + 2]]
            lines = [*pairwise(near)] or [(near[0], near[0])]
            aside = min(_distance(positions[substep, robot], *line) for line in lines)
            if aside > room:
                return f"robot {robot} is {aside:.3f} m off its route, at {substep}"
    return None


def _out_of_order(plan: Joint, positions: np.ndarray, spec: RobotSpec) -> str | None:
    """Compare the order in which robots have been in each cell with the plan."""
    seen = [[_cell(at, spec) for at in places] for places in positions]
    planned, driven = _visitors(plan), _visitors(seen)
    for cell, robots in planned.items():
        if driven[cell] != robots:
            return f"{cell} is entered by {driven[cell]}, not by {robots}"
    return None


def routes_of(plan: Joint) -> list[list[Place]]:
    """Return the cells of each robot without the steps in which it waits."""
    return [[cell for cell, _ in groupby(cells)] for cells in zip(*plan, strict=True)]


def _visitors(rows: Joint) -> dict[Place, list[int]]:
    """Return the robots that enter each cell, in order of time."""
    found: dict[Place, list[int]] = {}
    before: Sequence[Place | None] = [None] * len(rows[0])
    for cells in rows:
        for robot, (last, cell) in enumerate(zip(before, cells, strict=True)):
            if cell != last:
                found.setdefault(cell, []).append(robot)
        before = cells
    return found


def _cell(at: np.ndarray, spec: RobotSpec) -> Place:
    return math.floor(at[1] / spec.cell_size), math.floor(at[0] / spec.cell_size)


def _middle(cell: Place, spec: RobotSpec) -> tuple[float, float]:
    return (cell[1] + 0.5) * spec.cell_size, (cell[0] + 0.5) * spec.cell_size


def _distance(at: np.ndarray, one: Sequence[float], other: Sequence[float]) -> float:
    """Return the distance of a point from a line, along an axis, between two points."""
    low, high = np.minimum(one, other), np.maximum(one, other)
    return float(np.hypot(*(at - np.clip(at, low, high))))
