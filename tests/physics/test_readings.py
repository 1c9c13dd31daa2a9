"""Readings of velocity, force and energy along the path of a body."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from helpers.integrals import integral

from agents import GreedyAgent
from warehouse_core import Episode, Layout, Outcome, WarehouseEnv, record_episode
from warehouse_physics import DrivingMotion, RigidBodyMotion, RobotSpec
from warehouse_physics.body_motion import BodyMotion

EAST, SOUTH = (0, 1), (1, 0)
LANE = Layout(["......"])

SPECS = {
    "default": RobotSpec(),
    "wheels": RobotSpec(drive="differential", recuperation=0.5),
    "heavy": RobotSpec(payload_mass=200),
    "quick": RobotSpec(top_speed=2, acceleration=1.1, time_step=1 / 120),
}
over_specs = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())


def recorded(backend: BodyMotion) -> Episode:
    return record_episode(WarehouseEnv(backend=backend), GreedyAgent(seed=12), seed=12)


def driven(spec: RobotSpec) -> Iterator[Outcome]:
    """Yield the motions of a robot that drives through a lane in one go."""
    motion = DrivingMotion(spec)
    motion.reset(LANE, [(0, 0)], 0)
    for column in range(1, 6):
        motion.extend([(0, column)])
    for _ in range(6):
        yield from motion.drive(2.0)


@over_specs
@pytest.mark.parametrize("kind", ["moves", "driving"])
def test_the_speed_integrates_to_the_distance_and_the_energy_to_the_cost(spec, kind) -> None:
    motions = recorded(RigidBodyMotion(spec)).motions if kind == "moves" else [*driven(spec)]
    driven_by_speed = length = 0.0
    for motion in motions:
        assert motion.readings is not None
        assert motion.readings.shape == (len(motion.path), 5)
        assert not motion.readings.flags.writeable
        speeds = np.hypot(*motion.readings[:, :2].T)
        assert speeds.max() <= spec.top_speed * (1 + 1e-4)
        driven_by_speed += integral(speeds, motion.path[:, 0])
        length += np.hypot(*np.diff(motion.path[:, 1:3], axis=0).T).sum()
        assert motion.readings[-1, 4] == motion.joules
        if not spec.recuperation:
            assert (np.diff(motion.readings[:, 4]) >= 0).all()
    assert length > 4.9
    assert driven_by_speed == pytest.approx(length, rel=0.01)


def test_the_highest_speed_of_a_move_is_among_the_readings() -> None:
    """The default robot speeds up during half of a move, and brakes during the other half."""
    motion = recorded(RigidBodyMotion()).motions[3]
    speeds = np.hypot(*motion.readings[:, :2].T)
    assert speeds.max() == pytest.approx(1.0)
    assert motion.path[speeds.argmax(), 0] == pytest.approx(1.0)
    coarse = RigidBodyMotion(path_every=1000)
    coarse.reset(LANE, [(0, 0)], 0)
    [outcome] = coarse.advance([EAST], [False])
    assert np.hypot(*outcome.readings[:, :2].T).max() == pytest.approx(1.0)


@pytest.mark.parametrize("make", [RigidBodyMotion, DrivingMotion])
def test_the_motor_pushes_against_inertia_and_drag_and_brakes_with_the_rest(make) -> None:
    spec = RobotSpec()
    motion = make(spec, path_every=1)
    motion.reset(LANE, [(0, 0)], 0)
    if make is DrivingMotion:
        motion.extend([(0, 1)])
        [outcome] = motion.drive(2.5)
    else:
        [outcome] = motion.advance([EAST], [False])
    x = outcome.path[:, 1]
    vx, vy, fx, fy, _ = outcome.readings.T
    push, drag = spec.mass * spec.acceleration, spec.drag_force(loaded=False)
    assert (fx[0], fy[0]) == (0, 0)
    assert fx[10] == pytest.approx(push + drag, rel=1e-3)
    assert fx[80] == pytest.approx(drag - push, rel=1e-3)
    assert fy == pytest.approx(0)
    assert vy == pytest.approx(0)
    assert np.diff(x)[1:60] == pytest.approx(vx[1:60] * spec.time_step, rel=1e-6)


def test_the_motor_pushes_towards_a_wall_that_the_robot_hits_and_then_brakes() -> None:
    motion = RigidBodyMotion(path_every=1)
    motion.reset(Layout([".", "."]), [(0, 0)], 0)
    [outcome] = motion.advance([(0, -1)], [False])
    forces = outcome.readings[:, 2]
    hit = np.searchsorted(outcome.path[:, 0], outcome.contacts[0].seconds - 1e-9)
    assert forces[1 : hit - 1].max() < 0 < forces[hit + 5]


def test_a_disc_faces_the_direction_of_its_motion_from_the_first_substep_on() -> None:
    motion = RigidBodyMotion(path_every=1)
    motion.reset(Layout(["..", ".."]), [(0, 1)], 0)
    [west], [south] = (motion.advance([move], [False]) for move in ((0, -1), SOUTH))
    assert west.path[2:, 3] == pytest.approx(math.pi)
    assert south.path[2:, 3] == pytest.approx(math.pi / 2)
