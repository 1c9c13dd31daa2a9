"""One robot as a rigid body: its outcomes describe the motion of the body."""

import math
import random

import numpy as np
import pytest
from helpers.rigid_bodies import (
    EAST,
    LEDGE,
    MOVES,
    NORTH,
    SOUTH,
    STAY,
    WEST,
    drive_at_walls,
    motion_in,
    move,
)

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.motion.base import centre_of
from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec
from warehouse_physics.arena import WALL

TUNNEL_MOVES = 200
"""Moves at walls at the highest speed; the benchmarks make more."""

HALL = Layout(["......."] * 7)
TWO_ROOMS = Layout(["...#..."])

SPECS = {
    "default": RobotSpec(),
    "fast": RobotSpec.fast(),
    "small cells": RobotSpec(cell_size=0.5, radius=0.17, acceleration=2.0, motor_force=200.0),
}

over_specs = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())
over_loads = pytest.mark.parametrize("loaded", [False, True], ids=["empty", "loaded"])


def free_move(
    spec: RobotSpec, displacement: Cell = EAST, loaded: bool = False, path_every: int = 10
) -> Outcome:
    return move(motion_in(HALL, (3, 3), spec, path_every), displacement, loaded)


def bump(
    spec: RobotSpec, displacement: Cell = EAST, loaded: bool = False, path_every: int = 10
) -> Outcome:
    return move(motion_in(LEDGE, (0, 0), spec, path_every), displacement, loaded)


def velocities(outcome: Outcome) -> np.ndarray:
    """Return the velocity in m/s between each two rows of a path."""
    return np.diff(outcome.path[:, 1:3], axis=0) / np.diff(outcome.path[:, 0])[:, None]


def remove_walls(motion: RigidBodyMotion) -> None:
    space = motion._arena.space
    space.remove(*[shape for shape in space.shapes if shape.collision_type == WALL])


# Outcomes follow the bodies, not the grid.


def test_without_the_shapes_of_its_walls_the_robot_drives_through() -> None:
    motion = motion_in(TWO_ROOMS, (0, 2))
    assert move(motion, EAST).blocked
    remove_walls(motion)
    for col in (3, 4):
        outcome = move(motion, EAST)
        assert (outcome.cell, outcome.blocked, outcome.contacts) == ((0, col), False, ())


# Free moves.


@over_specs
@over_loads
def test_a_free_move_ends_at_rest_in_the_middle_of_the_next_cell(spec, loaded) -> None:
    for displacement in MOVES:
        motion = motion_in(HALL, (3, 3), spec)
        outcome = move(motion, displacement, loaded)
        cell = (3 + displacement[0], 3 + displacement[1])
        assert (outcome.cell, outcome.blocked, outcome.contacts) == (cell, False, ())
        assert math.dist(outcome.path[-1, 1:3], centre_of(cell, spec.cell_size)) < 1e-5
        assert motion._arena.robots[0].body.velocity.length < 1e-6


@over_specs
@over_loads
def test_a_free_move_takes_the_time_of_its_profile(spec, loaded) -> None:
    acceleration = spec.attainable_acceleration(loaded)
    speed = min(spec.top_speed, math.sqrt(acceleration * spec.cell_size))
    seconds = spec.cell_size / speed + speed / acceleration
    assert free_move(spec, loaded=loaded).seconds == pytest.approx(seconds, rel=0.05)


@over_specs
@over_loads
def test_top_speed_and_acceleration_are_kept(spec, loaded) -> None:
    outcome = free_move(spec, loaded=loaded, path_every=1)
    reached = velocities(outcome)
    changes = np.diff(reached, axis=0) / outcome.path[1, 0]
    acceleration = spec.attainable_acceleration(loaded)
    assert np.hypot(*reached.T).max() <= spec.top_speed * (1 + 1e-6)
    assert np.hypot(*changes.T).max() <= acceleration * (1 + 1e-6)
    # A slow robot would keep both limits too, so the test requires that they are reached.
    assert np.hypot(*changes.T).max() >= 0.9 * acceleration


@pytest.mark.parametrize("every", [1, 50])
def test_a_path_is_continuous(every: int) -> None:
    spec, stream = RobotSpec(), random.Random(1)
    motion = motion_in(Layout(["..#.", "....", ".#.."]), (1, 1), spec, every)
    for _ in range(40):
        outcome = move(motion, stream.choice(MOVES), stream.random() < 0.5)
        assert np.hypot(*velocities(outcome).T).max() <= spec.top_speed * (1 + 1e-6)
        assert np.diff(outcome.path[:, 0]).max() <= (every + 1e-6) * spec.time_step


@pytest.mark.parametrize("disturbances", [None, Disturbances(0.3, slippery="all", grip=0.1)])
def test_fast_robots_do_not_sink_deep_into_walls(disturbances: Disturbances | None) -> None:
    """Without shorter substeps, the last of these robots would sink in by half of its radius."""
    for speed, acceleration, radius, drive in (
        (1, 1, 0.35, "omnidirectional"),
        (3, 3, 0.35, "differential"),
        (4, 20, 0.2, "differential"),
        (3, 40, 0.1, "omnidirectional"),
    ):
        spec = RobotSpec(
            top_speed=speed, acceleration=acceleration, radius=radius, drive=drive,
            motor_force=5000,
        )  # fmt: skip
        motion, stream = RigidBodyMotion(spec, disturbances, path_every=1), random.Random(1)
        motion.reset(HALL, [(1, 1)], 0)
        rows, columns = HALL.height, HALL.width
        for _ in range(20):
            path = move(motion, stream.choice(MOVES)).path
            sides = path[:, 1], columns - path[:, 1], path[:, 2], rows - path[:, 2]
            assert min(side.min() for side in sides) >= 0.95 * radius


def test_without_recording_a_path_has_only_start_and_end() -> None:
    kept, left_off = RigidBodyMotion(), RigidBodyMotion(record_path=False)
    for motion in (kept, left_off):
        motion.reset(HALL, [(0, 0)], 0)
    for displacement in (EAST, NORTH, SOUTH, STAY, WEST, WEST):
        whole, ends = move(kept, displacement), move(left_off, displacement)
        assert np.array_equal(ends.path, whole.path[[0, -1]])
        # A robot at rest has no force, but the last recorded row belongs to its braking.
        assert np.array_equal(ends.readings[:, [0, 1, 4]], whole.readings[[0, -1]][:, [0, 1, 4]])
        assert ends._replace(path=whole.path, readings=whole.readings) == whole


@pytest.mark.parametrize("kilograms", [160, 200, 340])
def test_a_robot_that_the_floor_brakes_stops_once(kilograms: float) -> None:
    spec = RobotSpec(payload_mass=kilograms)
    assert spec.floor_deceleration > spec.attainable_acceleration(loaded=True)
    outcome = free_move(spec, loaded=True, path_every=1)
    assert outcome.seconds == pytest.approx(spec.move_seconds(loaded=True), rel=0.01)
    assert math.dist(outcome.path[-1, 1:3], (4.5, 3.5)) < 1e-5
    assert np.hypot(*velocities(outcome).T)[1:-1].min() > 0


def test_waiting_takes_the_dwell_and_costs_idle_power() -> None:
    outcome = free_move(RobotSpec(dwell=2.5, idle_power=8.0), STAY)
    assert (outcome.cell, outcome.blocked, outcome.seconds) == ((3, 3), False, 2.5)
    assert outcome.joules == pytest.approx(20.0)
    assert np.ptp(outcome.path[:, 1:], axis=0).max() == 0


# Bumps.


def test_a_hit_is_where_and_when_the_body_met_the_wall() -> None:
    outcome = bump(RobotSpec(), WEST)
    contact = outcome.contacts[0]
    assert contact.point == pytest.approx((0.0, 0.5), abs=0.01)
    # 0.15 m at 1 m/s² take sqrt(0.3) s; a substep to start and one to detect the hit.
    assert contact.seconds == pytest.approx(math.sqrt(0.3), abs=2.1 / 60)


@pytest.mark.parametrize("time_step", [1 / 60, 1 / 30])
def test_no_robot_drives_through_a_wall_at_the_highest_speed(time_step: float) -> None:
    drive_at_walls(time_step, TUNNEL_MOVES)
