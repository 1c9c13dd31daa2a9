"""Robots that drive through joint plans keep the order and their limits, and never touch."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.driving import Drive, crowds
from helpers.driving_validator import driving_fault
from hypothesis import given, settings

from warehouse_core import Cell, Layout
from warehouse_physics import RobotSpec

SPEC, FAST = RobotSpec(), RobotSpec.fast()


def ring_of(height: int, width: int) -> list[Cell]:
    """Return the cells at the edge of a floor, clockwise."""
    top, right = [(0, col) for col in range(width)], [(row, width - 1) for row in range(1, height)]
    bottom = [(height - 1, col) for col in range(width - 2, -1, -1)]
    return [*top, *right, *bottom, *((row, 0) for row in range(height - 2, 0, -1))]


def floor_of(height: int, width: int) -> Layout:
    return Layout(["." * width] * height)


def assert_drives(
    layout: Layout, plan: list[list[Cell]], spec: RobotSpec = SPEC, loaded: Sequence[bool] = ()
) -> Drive:
    drive = Drive(layout, plan, spec, loaded)
    assert driving_fault(plan, drive.positions, spec) is None
    assert drive.hits == 0
    return drive


@given(crowds())
@settings(max_examples=15)
def test_random_crowds_keep_the_order_of_the_plan(crowd) -> None:
    layout, plan, loaded, _ = crowd
    assert_drives(layout, plan, FAST, loaded)


@pytest.mark.parametrize(("height", "width"), [(2, 2), (2, 3), (3, 4)])
@pytest.mark.parametrize("gaps", [0, 1])
def test_rings_move_together(height: int, width: int, gaps: int) -> None:
    ring, steps = ring_of(height, width), 5
    robots = len(ring) - gaps
    plan = [[ring[(robot + step) % len(ring)] for robot in range(robots)] for step in range(steps)]
    rows = ["".join(".#"[(r, c) not in ring] for c in range(width)) for r in range(height)]
    drive = assert_drives(Layout(rows), plan)
    assert drive.seconds < 2.0 * (steps - 1)


@pytest.mark.parametrize("robots", [1, 2, 6])
def test_a_queue_drives_as_fast_as_its_first_robot(robots: int) -> None:
    plan = [[(0, robot + step) for robot in range(robots)] for step in range(7)]
    assert assert_drives(floor_of(1, robots + 6), plan).seconds == pytest.approx(7.0)


def test_a_queue_keeps_its_distance_from_a_slow_robot() -> None:
    plan = [[(0, robot + step) for robot in range(4)] for step in range(7)]
    layout = floor_of(1, 10)
    first = assert_drives(layout, plan, loaded=[False, False, False, True])
    second = assert_drives(layout, plan, loaded=[False, True, False, False])
    assert first.seconds == second.seconds > 7.1


@pytest.mark.parametrize("distance", [3, 4, 5])
def test_a_fast_robot_keeps_its_distance_from_one_that_turns_back_and_starts_slowly(
    distance: int,
) -> None:
    slow = [distance + abs(step - 2) for step in range(9)]
    plan = [[(0, step), (0, col)] for step, col in enumerate(slow)]
    assert_drives(floor_of(1, distance + 7), plan, loaded=[False, True])


def test_a_leg_that_grows_while_it_is_driven_takes_as_long_as_one_given_at_once() -> None:
    plan = [[(0, col), (0, col + 1)] for col in range(9)]
    layout = floor_of(1, 10)
    whole, grown = Drive(layout, plan), Drive(layout, plan, pause=0.5)
    assert whole.seconds == pytest.approx(9.0)
    assert np.array_equal(whole.positions, grown.positions[: len(whole.positions)])


def test_a_robot_rounds_a_corner_without_stopping() -> None:
    plan = [[(0, col)] for col in range(4)] + [[(row, 3)] for row in range(1, 4)]
    drive = assert_drives(floor_of(4, 4), plan)
    assert drive.seconds < 7.7  # two legs from rest to rest take 8 s
    back = [[(0, col)] for col in (0, 1, 2, 3, 2, 1, 0)]
    assert assert_drives(floor_of(1, 4), back).seconds == pytest.approx(8.0)


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("cells", [1, 2, 9])
def test_a_lone_robot_takes_the_time_and_energy_of_the_formula(cells: int, loaded: bool) -> None:
    drive = Drive(floor_of(1, 10), [[(0, col)] for col in range(cells + 1)], SPEC, [loaded])
    mass, drag = SPEC.total_mass(loaded), SPEC.drag_force(loaded)
    up = min(SPEC.acceleration, (SPEC.motor_force - drag) / mass)
    down = min(SPEC.acceleration, (SPEC.motor_force + drag) / mass)
    speed = min(SPEC.top_speed, math.sqrt(2 * cells * up * down / (up + down)))
    seconds = cells / speed + speed * (1 / up + 1 / down) / 2
    assert drive.seconds == pytest.approx(seconds, abs=2 * SPEC.time_step)
    # While the robot brakes, the drag helps and the motor does no work.
    work = mass * speed**2 / 2 + drag * (cells - speed**2 / 2 / down)
    joules = work / SPEC.drivetrain_efficiency + SPEC.idle_power * drive.seconds
    assert drive.joules == pytest.approx([joules], rel=3e-3)
