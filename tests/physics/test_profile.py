"""A leg against Chipmunk's own order of things: positions move before velocities change."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warehouse_physics.profile import Leg, braking, plan_leg

places = st.tuples(st.floats(-50, 50), st.floats(-50, 50))
lengths = st.floats(1e-3, 5.0)
angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.05, 10.0)
accelerations = st.floats(0.05, 50.0)
time_steps = st.sampled_from([1 / 240, 1 / 120, 1 / 60, 1 / 30, 0.1])


def drive(leg: Leg, acceleration: float, time_step: float) -> tuple[list[float], list[float]]:
    """Return the positions along the leg and the speeds after each substep, from rest at 0."""
    position = speed = 0.0
    positions, speeds = [position], [speed]
    for command, substeps in ((math.hypot(*leg.velocity), leg.go), (0.0, leg.brake)):
        for _ in range(substeps):
            position += speed * time_step
            change = acceleration * time_step
            speed += min(max(command - speed, -change), change)
            positions.append(position)
            speeds.append(speed)
    return positions, speeds


def leg_over(start, length, angle, *limits) -> Leg:
    target = (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))
    return plan_leg(start, target, *limits)


@given(places, lengths, angles, speeds, accelerations, time_steps)
def test_a_leg_ends_at_rest_at_its_target(start, length, angle, speed, pace, step) -> None:
    leg = leg_over(start, length, angle, speed, pace, step)
    positions, reached = drive(leg, pace, step)
    assert positions[-1] == pytest.approx(length, rel=1e-6, abs=1e-9)
    assert abs(reached[-1]) <= 1e-7 * speed
    direction = math.atan2(leg.velocity[1], leg.velocity[0])
    assert math.remainder(direction - angle, math.tau) == pytest.approx(0, abs=1e-9)


@given(places, lengths, angles, speeds, accelerations, time_steps)
def test_a_leg_keeps_to_speed_and_acceleration(start, length, angle, speed, pace, step) -> None:
    leg = leg_over(start, length, angle, speed, pace, step)
    positions, reached = drive(leg, pace, step)
    assert max(reached) <= speed * (1 + 1e-6)
    changes = [after - before for before, after in itertools.pairwise(reached)]
    assert max(map(abs, changes)) <= pace * step * (1 + 1e-6)
    assert positions == sorted(positions)


@given(places, lengths, angles, speeds, accelerations, time_steps)
def test_no_leg_of_fewer_substeps_would_do(start, length, angle, speed, pace, step) -> None:
    leg = leg_over(start, length, angle, speed, pace, step)
    if leg.go > 1:
        hurried = length / ((leg.go - 1) * step)
        too_fast = hurried > speed * (1 - 1e-6)
        too_sudden = hurried > (leg.go - 1) * pace * step * (1 - 1e-6)
        assert too_fast or too_sudden


def test_one_cell_at_one_metre_a_second_takes_two_seconds() -> None:
    leg = plan_leg((0.5, 0.5), (1.5, 0.5), 1.0, 1.0, 1 / 60)
    assert (leg.go, leg.brake) == (60, 60)
    assert leg.velocity == pytest.approx((1.0, 0.0))


def test_a_target_where_it_stands_is_no_error() -> None:
    assert plan_leg((1.0, 2.0), (1.0, 2.0), 1.0, 1.0, 1 / 60) == Leg((0.0, 0.0), 1, 1)


@given(st.floats(0, 10), accelerations, time_steps)
def test_braking_lasts_until_it_stands_and_no_longer(speed, pace, step) -> None:
    substeps = braking(speed, pace, step)
    left = speed - substeps * pace * step
    assert left <= 1e-6 * pace * step
    assert substeps == 1 or left + pace * step > 0


def test_a_leg_scaled_is_as_long_but_faster_or_slower() -> None:
    assert Leg((2.0, -1.0), 5, 3).scaled(1.5) == Leg((3.0, -1.5), 5, 3)
