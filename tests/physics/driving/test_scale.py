"""Robots on a floor of twice the size do exactly the same, twice as far."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec

FLOOR = Layout(["........", ".#.##.#.", "........"])
RING = [
    *((0, col) for col in range(8)), (1, 7),
    *((2, col) for col in range(7, -1, -1)), (1, 0),
]  # fmt: skip
PLAN = [[RING[(first + step) % len(RING)] for first in (0, 5, 10)] for step in range(20)]
SPEC = RobotSpec(radius=0.3)


def scaled(scale: float) -> RobotSpec:
    """Return a robot whose lengths, speeds and accelerations are ``scale`` times as large."""
    names = "cell_size", "radius", "top_speed", "acceleration", "motor_force", "floor_drag"
    values = {name: scale * getattr(SPEC, name) for name in names}
    return replace(SPEC, **values, idle_power=scale**2 * SPEC.idle_power)


def driven(scale: float, disturbances: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions of all substeps and the joules of all robots."""
    if "grip" in disturbances:
        disturbances = disturbances | {"grip": scale * disturbances["grip"]}
    motion = DrivingMotion(scaled(scale), Disturbances(**disturbances), path_every=1)
    motion.reset(FLOOR, PLAN[0], 3)
    for cells in PLAN[1:]:
        motion.extend(cells)
    outcomes = motion.drive(9.0)
    paths = np.stack([outcome.path for outcome in outcomes])
    return paths[..., 1:3], np.array([outcome.joules for outcome in outcomes])


@pytest.mark.parametrize(
    "disturbances",
    [
        {}, {"actuation_noise": 0.1}, {"drag_spread": 0.5},
        {"slippery": frozenset({(0, 3)}), "grip": 0.05},
    ],
    ids=str,
)  # fmt: skip
def test_twice_the_size_is_the_same_drive(disturbances: dict[str, Any]) -> None:
    paths, joules = driven(1.0, disturbances)
    large_paths, large_joules = driven(2.0, disturbances)
    assert np.ptp(paths, axis=1).max() > 4, "they have driven"
    assert (large_paths == 2 * paths).all()
    assert (large_joules == 4 * joules).all()
