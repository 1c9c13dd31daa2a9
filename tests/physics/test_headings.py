"""Fleets of bodies whose robots have headings: they turn in their cells and drive forwards."""

import math

import numpy as np
import pytest

from warehouse_core import FleetEnv, Layout, shelf_layout
from warehouse_physics import RigidBodyMotion, RobotSpec

FORWARD, RIGHT, LEFT, WAIT = range(4)
ANGLES = [-math.pi / 2, 0.0, math.pi / 2, math.pi]
SHELVES = shelf_layout(2, 2, aisle=2)
QUARTER = 1.5
SPECS = {
    "free": RobotSpec(),
    "turning": RobotSpec(turn_seconds=QUARTER),
    "wheels": RobotSpec(drive="differential"),
}


def fleet(spec: RobotSpec, robots: int, layout: Layout = SHELVES, **settings: object) -> FleetEnv:
    env = FleetEnv(
        layout, robots, backend=RigidBodyMotion(spec), moves="turn", max_steps=300, battery=300,
        **settings,  # type: ignore[arg-type]
    )  # fmt: skip
    env.reset(seed=1)
    return env


@pytest.mark.parametrize("name", SPECS)
def test_bodies_end_where_robots_of_the_grid_do_and_head_there(name: str) -> None:
    bodies, grid = fleet(SPECS[name], 10), FleetEnv(SHELVES, 10, moves="turn", max_steps=300)
    grid.reset(seed=1)
    stream, hits = np.random.default_rng(2), 0
    for _ in range(80):
        actions = np.where(stream.random(10) < 0.5, FORWARD, stream.integers(4, size=10))
        (_, rewards, *_), (_, expected, *_) = bodies.step(actions), grid.step(actions)
        assert (bodies.cells, bodies.headings) == (grid.cells, grid.headings)
        assert rewards.tolist() == expected.tolist()
        for outcome, heading in zip(bodies.last_motion, bodies.headings, strict=True):
            assert abs(math.remainder(outcome.path[-1, 3] - ANGLES[heading], math.tau)) < 0.02
            hits += outcome.blocked
    assert hits > 20


@pytest.mark.parametrize(("action", "sign"), [(RIGHT, 1), (LEFT, -1)])
def test_a_turn_takes_a_quarter_in_place_while_others_drive(action: int, sign: int) -> None:
    env = fleet(SPECS["turning"], 2, Layout(["...."] * 2), starts=[(0, 0), (1, 0)])
    env.step([action, FORWARD])
    turned, driven = env.last_motion
    assert turned.seconds == pytest.approx(QUARTER, abs=0.02)
    assert driven.seconds == pytest.approx(RobotSpec().move_seconds(loaded=False), abs=0.02)
    assert np.ptp(turned.path[:, 1:3], axis=0).max() == 0
    assert turned.path[-1, 3] - turned.path[0, 3] == pytest.approx(sign * math.pi / 2, abs=0.02)
    env.step([WAIT, WAIT])
    assert np.ptp(env.last_motion[0].path[:, 3]) == 0


def test_wheels_pay_for_a_turn_and_an_omnidirectional_robot_only_waits() -> None:
    joules = {}
    for name, spec in SPECS.items():
        env = fleet(spec, 1)
        env.step([RIGHT])
        seconds = env.last_motion[0].seconds
        joules[name] = env.last_motion[0].joules - spec.idle_power * seconds
        assert seconds < 2.1
    assert joules["free"] == joules["turning"] == pytest.approx(0)
    assert joules["wheels"] > 5


def test_a_reset_forgets_turns_and_directions_are_checked() -> None:
    motion = RigidBodyMotion(SPECS["turning"])
    with pytest.raises(RuntimeError, match=r"^face\(\) needs a reset\(\)"):
        motion.face([(1, 0)])
    motion.reset(SHELVES, [(1, 1)], 0)
    with pytest.raises(ValueError, match=r"^2 directions for 1 robots"):
        motion.face([(1, 0)] * 2)
    motion.face([(1, 0)])
    motion.reset(SHELVES, [(1, 1)], 0)
    assert motion.advance([(0, 0)], [False])[0].path[-1, 3] == 0
    motion.face([(1, 0)])
    assert motion.advance([(0, 1)], [False])[0].path[-1, 3] == 0  # it drives, and turns no further
