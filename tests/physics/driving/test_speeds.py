"""Speeds from which bodies can still stop, checked by braking substep by substep."""

import numpy as np
import pytest

from warehouse_physics.profile import stopping_distances, stopping_speeds

DT = 1 / 60
RATES = np.array([0.3, 1.0, 7.0])


def braked(speed: float, rate: float) -> float:
    """Return how far a body gets that is commanded a speed for a substep, and then brakes."""
    way = 0.0
    while speed > 0:
        way += speed * DT
        speed -= rate * DT
    return way


@pytest.mark.parametrize("distance", [1e-4, 0.01, 0.3, 0.5, 4.0])
def test_the_highest_speed_is_that_with_which_a_body_still_stops(distance: float) -> None:
    speeds = stopping_speeds(np.full(3, distance), RATES, DT)
    for speed, rate in zip(speeds.tolist(), RATES.tolist(), strict=True):
        assert braked(speed, rate) <= distance * (1 + 1e-9) + rate * DT * DT / 4
        assert braked(speed + rate * DT, rate) > distance


def test_nobody_may_move_on_who_has_no_way_left() -> None:
    assert stopping_speeds(np.array([0.0, -1.0]), np.ones(2), DT).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("substeps", [0, 1, 5, 60])
def test_a_stopping_distance_is_the_way_of_a_body_that_brakes(substeps: int) -> None:
    speeds = substeps * RATES * DT
    found = stopping_distances(speeds, RATES, DT)
    steps = np.arange(substeps, 0, -1).sum()
    assert found == pytest.approx(RATES * DT * DT * steps)
