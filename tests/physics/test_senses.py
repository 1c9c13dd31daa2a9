"""What bodies sense: scans of walls and robots, and odometry that drifts."""

import copy
import math
import pickle
import random
import statistics
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from warehouse_core import Cell, Layout
from warehouse_core.errors import BackendError
from warehouse_core.gymnasium_env import WarehouseGymnasiumEnv, WarehouseVectorEnv
from warehouse_core.motion.base import SCAN_RANGE
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec

HALL = Layout(["." * 30] * 3)
STEPS: list[Cell] = [(0, 1), (1, 0), (0, -1), (-1, 0), (0, 0)]
DRIFTING = Disturbances(odometry=0.01)

over_motions = pytest.mark.parametrize("kind", [RigidBodyMotion, DrivingMotion])


def placed(motion: Any, layout: Layout, *cells: Cell, seed: int | None = 0) -> Any:
    motion.reset(layout, list(cells), seed)
    return motion


@over_motions
def test_a_scan_goes_from_east_to_south_up_to_walls_robots_and_its_range(kind) -> None:
    motion = placed(kind(RobotSpec(cell_size=2.0)), HALL, (1, 3), (1, 5), (1, 15))
    near, half = 4.0 - 0.35, math.sqrt(2) * 3.0
    first = [near, half, 3.0, half, 7.0, half, 3.0, half]
    assert motion.scan(0, 8) == pytest.approx(first, abs=1e-5)
    assert motion.scan(2, 4).tolist() == pytest.approx([SCAN_RANGE, 3.0, SCAN_RANGE, 3.0])
    assert motion.scan(1, 1).tolist() == [SCAN_RANGE]


@over_motions
def test_sensors_change_no_motion(kind: Any) -> None:
    rough = {"actuation_noise": 0.1, "drag_spread": 0.3}
    for numbers in ({}, rough):
        pair = (
            kind(None, Disturbances(**numbers)),
            kind(None, Disturbances(**numbers, odometry=0.2)),
        )
        for motion in pair:
            placed(motion, HALL, (1, 1), (1, 2), (0, 1))
        draws = random.Random(3)
        for _ in range(15):
            moves = [draws.choice(STEPS) for _ in range(3)]
            pair[1].scan(1, 7)
            plain, sensing = (pickle.dumps(each.advance(moves, [True] * 3)) for each in pair)
            assert plain == sensing
        assert pair[0].odometry(2) is None
        assert pair[1].odometry(2) is not None


def test_odometry_measures_distances_with_its_error() -> None:
    motion, shares, drifts = RigidBodyMotion(None, DRIFTING), [], []
    for seed in range(150):
        placed(motion, HALL, (1, 1), seed=seed)
        assert motion.odometry(0) == (1.5, 1.5, 0.0)
        motion.advance([(0, 1)], [False])
        x, y, heading = motion.odometry(0)
        assert math.atan2(y - 1.5, x - 1.5) == pytest.approx(heading, abs=1e-4)
        shares.append(math.hypot(x - 1.5, y - 1.5))
        drifts.append(heading)
    for errors, mean in ((shares, 1.0), (drifts, 0.0)):
        assert statistics.mean(errors) == pytest.approx(mean, abs=0.003)
        assert statistics.stdev(errors) == pytest.approx(0.01, rel=0.15)


@over_motions
def test_odometry_drifts_by_its_seed_and_goes_on_in_a_copy(kind: Any) -> None:
    motions = [placed(kind(None, DRIFTING), HALL, (1, 1), (0, 5), seed=seed) for seed in (1, 1, 2)]
    for displacement in [(0, 1)] * 6:
        for each in motions:
            last = each.advance([displacement, (0, 0)], [False] * 2)
    motions.append(copy.deepcopy(motions[0]))
    for each in (motions[0], motions[1], motions[3]):
        each.advance([(1, 0), (0, 0)], [False] * 2)
    first, same, other, twin = ([each.odometry(0), each.odometry(1)] for each in motions)
    assert first == same == twin
    assert first[0] != other[0]
    assert 0 < math.dist(other[0][:2], last[0].path[-1, 1:3]) < 1.0
    assert other[1] == (5.5, 0.5, 0.0)  # a robot that does not move makes no error


def test_turns_add_to_the_error_of_the_heading() -> None:
    motion = RigidBodyMotion(RobotSpec(turn_seconds=1.0), DRIFTING)
    drifts = []
    for seed in range(150):
        placed(motion, HALL, (1, 1), seed=seed)
        motion.advance([(1, 0)], [False])
        x, y, heading = motion.odometry(0)
        assert math.atan2(y - 1.5, x - 1.5) == pytest.approx(heading, abs=1e-4)
        drifts.append(heading - math.pi / 2)
    assert statistics.stdev(drifts) == pytest.approx(0.01 * (1 + math.pi / 2), rel=0.15)


def test_robots_and_rays_that_do_not_exist_are_refused() -> None:
    motion = RigidBodyMotion()
    for call in (lambda: motion.scan(0, 4), lambda: motion.odometry(0)):
        with pytest.raises(RuntimeError, match="needs a reset"):
            call()
    placed(motion, HALL, (1, 1))
    with pytest.raises(ValueError, match="robot is 1; it must be"):
        motion.odometry(1)
    for robot, rays in ((1, 4), (0, 0), (0, 1001)):
        with pytest.raises(ValueError, match="; it must be"):
            motion.scan(robot, rays)


# Gymnasium.


def test_the_checker_of_gymnasium_passes_with_sensors() -> None:
    motion = RigidBodyMotion(None, Disturbances(odometry=0.5))
    check_env(WarehouseGymnasiumEnv(backend=motion, scan=16), skip_render_check=True)
    env = WarehouseGymnasiumEnv(backend=motion, scan=16, max_steps=30)
    first, _ = env.reset(seed=5)
    env.action_space.seed(1)
    actions = [env.action_space.sample() for _ in range(20)]
    seen = [first] + [env.step(action)[0] for action in actions]
    assert all(env.observation_space.contains(each) for each in seen)
    inner: Any = env.warehouse.motion
    np.testing.assert_array_equal(seen[-1]["scan"], inner.scan(0, 16).astype(np.float32))
    np.testing.assert_array_equal(seen[-1]["odometry"], np.float32(inner.odometry(0)))
    again = [env.reset(seed=5)[0]] + [env.step(action)[0] for action in actions]
    assert pickle.dumps(seen) == pickle.dumps(again)
    plain = WarehouseGymnasiumEnv(backend="physics")
    assert plain.observation_space.spaces.keys() == plain.reset()[0].keys()
    assert {"scan", "odometry"} == first.keys() - plain.reset()[0].keys()


def test_environments_without_sensors_refuse_them_in_a_line() -> None:
    with pytest.raises(
        BackendError, match=r"^scan is 16, but backend 'grid' does not support scans"
    ):
        WarehouseGymnasiumEnv(scan=16)
    with pytest.raises(ValueError, match=r"^observation is 'vector'; it must be 'dict' for scan$"):
        WarehouseGymnasiumEnv(backend="physics", observation="vector", scan=16)
    drifting = RigidBodyMotion(None, DRIFTING)
    with pytest.raises(ValueError, match=r"it must be 'dict' for odometry$"):
        WarehouseGymnasiumEnv(backend=drifting, observation="image")
    with pytest.raises(ValueError, match=r"^scan is 16; a batch has no sensors"):
        WarehouseVectorEnv(2, backend="physics", scan=16)
    with pytest.raises(ValueError, match="cannot be batched"):
        WarehouseVectorEnv(2, backend=drifting)
    name = "warehouse_core.gymnasium_env:Warehouse-v0"
    settings: Any = {"backend": "physics", "scan": 4, "vectorization_mode": "sync"}
    envs = gymnasium.make_vec(name, 2, **settings)
    assert envs.reset(seed=0)[0]["scan"].shape == (2, 4)
