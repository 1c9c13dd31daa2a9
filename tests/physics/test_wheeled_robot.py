"""Robots with two driven wheels, which push along the heading and turn on the spot."""

import math

import numpy as np
import pytest
from helpers.physics_truth import differences_in_jams, errors_of_the_books
from helpers.rigid_bodies import EAST, NORTH, SOUTH, STAY, WEST, motion_in, move, together

from warehouse_core import Cell, Layout
from warehouse_core.motion.grid import GRAVITY
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec, stepping

HALL = Layout(["....."] * 5)
WHEELED = RobotSpec(drive="differential")
QUARTER = 2 * math.sqrt(math.pi / 2 * WHEELED.wheel_arm / WHEELED.acceleration)
"""Seconds of a quarter turn: a wheel speeds up over half of its distance and then brakes."""


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize(("displacement", "angle"), [(SOUTH, 1), (NORTH, -1), (WEST, 2)])
def test_a_turn_takes_the_time_and_energy_of_a_wheel_that_drives_its_arc(
    displacement: Cell, angle: int, loaded: bool
) -> None:
    outcome = move(motion_in(HALL, (2, 2), WHEELED, path_every=1), displacement, loaded)
    straight = move(motion_in(HALL, (2, 2), WHEELED), EAST, loaded)
    clock, x, y, heading = outcome.path.T
    distance = WHEELED.wheel_arm * abs(angle) * math.pi / 2
    inertia = WHEELED.total_mass(loaded) * WHEELED.radius**2 / 2 / WHEELED.wheel_arm**2
    drag = WHEELED.drag_force(loaded)
    rate = min(WHEELED.acceleration, (WHEELED.motor_force - drag) / inertia)
    seconds = 2 * math.sqrt(distance / rate)
    assert outcome.seconds - straight.seconds == pytest.approx(seconds, abs=0.04)
    turns = clock < seconds
    assert x[turns] == pytest.approx(2.5, abs=1e-12)
    assert y[turns] == pytest.approx(2.5, abs=1e-12)
    assert abs(heading[-1]) == pytest.approx(abs(angle) * math.pi / 2)
    assert abs(heading[len(clock[turns]) // 2]) == pytest.approx(abs(angle) * math.pi / 4, rel=0.05)
    # A wheel speeds up over half of the distance. Then the motors brake and spend nothing.
    work = inertia * rate * distance / 2 + drag * distance / 2
    joules = work / WHEELED.drivetrain_efficiency + WHEELED.idle_power * seconds
    assert outcome.joules - straight.joules == pytest.approx(joules, rel=0.05)


def test_it_goes_back_from_a_wall_without_turning_and_then_turns_from_there() -> None:
    motion = motion_in(HALL, (0, 0), WHEELED, path_every=1)
    blocked = move(motion, WEST)
    assert blocked.blocked
    assert blocked.path[-1, 1:3] == pytest.approx((0.5, 0.5), abs=1e-3)
    heading = np.abs(blocked.path[:, 3])
    assert heading[-1] == pytest.approx(math.pi)
    assert np.diff(heading).min() >= -1e-9
    east = move(motion, EAST)
    assert east.seconds == pytest.approx(math.sqrt(2) * QUARTER + 2, abs=0.05)


def test_robots_that_turn_the_same_corner_wait_for_the_longest_turn_and_do_not_touch() -> None:
    ring = [(1, 1), (1, 2), (2, 2), (2, 1)]
    moves = [EAST, SOUTH, WEST, NORTH]
    outcomes = together(HALL, ring, moves, WHEELED, path_every=1)
    assert [outcome.cell for outcome in outcomes] == [*ring[1:], ring[0]]
    assert not any(outcome.contacts for outcome in outcomes)
    assert {outcome.seconds for outcome in outcomes} == {outcomes[0].seconds}
    with pytest.raises(ValueError, match=r"^radius is 0\.36; .* at most 0\.35 for 4 robots"):
        together(HALL, ring, moves, RobotSpec(drive="differential", radius=0.36))


def test_robots_that_hit_each_other_leave_their_lines_only_where_the_floor_is_slippery() -> None:
    """Two robots drive to the same cell, from the west and from the north."""
    asides = []
    for slippery in ([], [(2, 1), (2, 2), (1, 2)]):
        ice = Disturbances(slippery=slippery, grip=0.2)
        motion = RigidBodyMotion(WHEELED, ice, path_every=1)
        motion.reset(HALL, [(2, 1), (1, 2)], 0)
        outcomes = motion.advance([EAST, SOUTH], [False] * 2)
        assert all(outcome.contacts for outcome in outcomes)
        asides.append(max(np.ptp(outcomes[0].path[:, 2]), np.ptp(outcomes[1].path[:, 1])))
        if not slippery:
            assert (outcomes[0].path[-1, 2], outcomes[1].path[-1, 1]) == pytest.approx((2.5, 2.5))
    assert asides[0] < 1e-3 < 0.02 < asides[1]


def test_on_ice_a_turn_takes_several_attempts_and_ends_where_it_should() -> None:
    ice = Disturbances(slippery=[(2, 2)], grip=0.06, patience=20)
    motion = RigidBodyMotion(WHEELED, ice, path_every=1)
    motion.reset(HALL, [(2, 2)], 0)
    outcome = move(motion, SOUTH)
    assert outcome.cell == (3, 2)
    assert outcome.path[-1, 3] == pytest.approx(math.pi / 2, abs=1e-3)
    away = np.flatnonzero(np.hypot(*(outcome.path[:, 1:3] - 2.5).T) > 1e-3)[0]
    assert outcome.path[away, 0] > 1.5 * QUARTER
    assert outcome.path[away, 3] == pytest.approx(math.pi / 2, abs=2e-3)
    grip, drag = 0.06 * WHEELED.mass * GRAVITY, WHEELED.drag_force(loaded=False)
    rims = WHEELED.wheel_arm * np.diff(outcome.path[:away, 3]) / WHEELED.time_step
    most = (grip - drag) / WHEELED.turning_mass(loaded=False)
    assert np.diff(rims).max() / WHEELED.time_step == pytest.approx(most, rel=1e-3)


def test_the_joules_of_turns_drives_and_hits_are_those_of_a_second_book(monkeypatch) -> None:
    monkeypatch.setattr(stepping, "IS_KNOWN", False)
    lone = errors_of_the_books(40, 1, drive="differential")
    assert max(lone.joules) < 1e-6
    several = errors_of_the_books(40, 6, drive="differential")
    assert max(several.joules) < 0.01
    assert len(several.impulses) > 5
    assert max(several.impulses) < 1e-6


def test_braking_in_a_turn_gives_energy_back() -> None:
    stopping, through = [], []
    for share in (0.0, 1.0):
        spec = RobotSpec(drive="differential", recuperation=share)
        stopping.append(move(motion_in(HALL, (2, 2), spec), SOUTH).joules)
        stopping.append(move(motion_in(HALL, (2, 2), spec), EAST).joules)
        for displacement in (SOUTH, EAST):
            motion = DrivingMotion(spec)
            motion.reset(HALL, [(2, 2)], 0)
            steps = [displacement, *[STAY] * 6]
            through.append(sum(motion.advance([step], [False])[0].joules for step in steps))
    rim = QUARTER / 2 * WHEELED.acceleration
    braked = (
        WHEELED.turning_mass(False) * rim**2 / 2 - WHEELED.drag_force(False) * rim * QUARTER / 4
    )
    for turned, drove, gave_back, drove_back in (stopping, through):
        regained = (turned - drove) - (gave_back - drove_back)
        assert regained == pytest.approx(braked, rel=0.06)


def test_jams_end_as_on_the_grid() -> None:
    made, wrong, cut_off = differences_in_jams(600, drive="differential")
    assert (made >= 600, wrong, cut_off) == (True, 0, 0)
