"""Profiles, simulated in Chipmunk's order: positions move before velocities change."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_physics.profile import (
    Profile,
    braking,
    brakings,
    plan_profile,
    plan_profiles,
    stopping_distances,
    stopping_speeds,
)

places = st.tuples(st.floats(-50, 50), st.floats(-50, 50))
lengths = st.floats(1e-3, 5.0)
angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.05, 10.0)
accelerations = st.floats(0.05, 50.0)
time_steps = st.sampled_from([1 / 240, 1 / 120, 1 / 60, 1 / 30, 0.1])


def drive(
    profile: Profile, acceleration: float, time_step: float, drag: float = 0.0
) -> tuple[list[float], list[float]]:
    """Return the positions along the profile and the speeds after each substep, from rest at 0."""
    rates = acceleration, max(acceleration, drag)
    position = speed = 0.0
    positions, speeds = [position], [speed]
    legs = ((math.hypot(*profile.velocity), profile.go), (0.0, profile.brake))
    for (command, substeps), rate in zip(legs, rates, strict=True):
        for _ in range(substeps):
            position += speed * time_step
            change = rate * time_step
            speed += min(max(command - speed, -change), change)
            positions.append(position)
            speeds.append(speed)
    return positions, speeds


def profile_over(start, length, angle, *limits) -> Profile:
    target = (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))
    return plan_profile(start, target, *limits)


@settings(max_examples=60)
@given(places, lengths, angles, speeds, accelerations, time_steps)
def test_a_profile_ends_at_rest_at_its_target_as_early_as_its_limits_allow(
    start, length, angle, speed, acceleration, step
) -> None:
    profile = profile_over(start, length, angle, speed, acceleration, step)
    positions, reached = drive(profile, acceleration, step)
    assert positions[-1] == pytest.approx(length, rel=1e-6, abs=1e-9)
    assert abs(reached[-1]) <= 1e-7 * speed
    direction = math.atan2(profile.velocity[1], profile.velocity[0])
    assert math.remainder(direction - angle, math.tau) == pytest.approx(0, abs=1e-9)
    assert max(reached) <= speed * (1 + 1e-6)
    changes = [after - before for before, after in itertools.pairwise(reached)]
    assert max(map(abs, changes)) <= acceleration * step * (1 + 1e-6)
    assert positions == sorted(positions)
    if profile.go > 1:  # with one substep less it would be too fast, or too sudden
        hurried = length / ((profile.go - 1) * step)
        allowed = min(speed, (profile.go - 1) * acceleration * step)
        assert hurried > allowed * (1 - 1e-6)


@settings(max_examples=60)
@given(places, lengths, angles, speeds, st.floats(0.05, 5.0), st.floats(1.0, 500.0), time_steps)
def test_a_robot_that_the_floor_brakes_ends_at_rest_at_its_target(
    start, length, angle, speed, acceleration, harder, step
) -> None:
    drag, acceleration = acceleration * harder, min(acceleration, speed / step)
    profile = profile_over(start, length, angle, speed, acceleration, step, drag)
    positions, reached = drive(profile, acceleration, step, drag)
    assert positions[-1] == pytest.approx(length, rel=1e-6, abs=1e-9)
    assert abs(reached[-1]) <= 1e-5 * speed
    assert max(reached) <= speed * (1 + 1e-6)
    if profile.go > 2:
        # The distance with two substeps less, at the highest speed, is shorter.
        fastest = min(speed, (profile.go - 2) * acceleration * step)
        hurried = Profile((fastest, 0.0), profile.go - 2, braking(fastest, drag, step))
        assert drive(hurried, acceleration, step, drag)[0][-1] < length


def test_a_profile_to_the_same_position_does_not_move() -> None:
    assert plan_profile((1.0, 2.0), (1.0, 2.0), 1.0, 1.0, 1 / 60) == Profile((0.0, 0.0), 1, 1)


displacements = st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=5)


@settings(max_examples=40)
@given(displacements, speeds, st.tuples(accelerations, accelerations), time_steps)
def test_plans_for_a_batch_equal_single_profiles(displacements, speed, rates, time_step) -> None:
    acceleration = np.resize(rates, len(displacements))
    velocities, go, brake = plan_profiles(np.array(displacements), speed, acceleration, time_step)
    lengths = np.hypot(*np.array(displacements).T)
    stops = brakings(lengths, acceleration, time_step)
    for row, target in enumerate(displacements):
        profile = plan_profile((0.0, 0.0), target, speed, acceleration[row], time_step)
        assert velocities[row] == pytest.approx(profile.velocity, rel=1e-9)
        assert (go[row], brake[row]) == (profile.go, profile.brake)
        assert stops[row] == braking(lengths[row], acceleration[row], time_step)


# Speeds from which bodies can still stop.

DT = 1 / 60
RATES = np.array([0.3, 1.0, 7.0])


def braked(speed: float, rate: float) -> float:
    """Return how far a body gets that is commanded a speed for one substep and then brakes."""
    distance = 0.0
    while speed > 0:
        distance += speed * DT
        speed -= rate * DT
    return distance


@pytest.mark.parametrize("distance", [1e-4, 0.01, 0.3, 0.5, 4.0])
def test_the_highest_speed_is_that_with_which_a_body_still_stops(distance: float) -> None:
    speeds = stopping_speeds(np.full(3, distance), RATES, DT)
    for speed, rate in zip(speeds.tolist(), RATES.tolist(), strict=True):
        assert braked(speed, rate) <= distance * (1 + 1e-9) + rate * DT * DT / 4
        assert braked(speed + rate * DT, rate) > distance


def test_a_body_without_distance_to_stop_must_not_move() -> None:
    assert stopping_speeds(np.array([0.0, -1.0]), np.ones(2), DT).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("substeps", [0, 1, 5, 60])
def test_a_stopping_distance_is_how_far_a_body_gets_that_brakes(substeps: int) -> None:
    speeds = substeps * RATES * DT
    steps = np.arange(substeps, 0, -1).sum()
    assert stopping_distances(speeds, RATES, DT) == pytest.approx(RATES * DT * DT * steps)
