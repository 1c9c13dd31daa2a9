"""Episodes on the physics backend are equal to episodes on the grid."""

from dataclasses import replace
from typing import Any

import pytest
from helpers.fleet_truth import bodies_move_as_the_grid
from helpers.rigid_bodies import steps_differ
from helpers.traces import TRACES, assert_as_recorded, env_of

from warehouse_core import DEFAULT_LAYOUT, WarehouseEnv
from warehouse_core.conformance import run_conformance
from warehouse_physics import RigidBodyMotion, RobotSpec
from warehouse_physics.spec import FAST_STEP

MOVES = 800
"""Random actions on both backends; the benchmarks make more."""

TRACE_STRIDE = 12
"""Only every twelfth recorded episode is replayed."""

TURNING = RobotSpec(turn_seconds=1.6)
WHEELED = RobotSpec(drive="differential", time_step=FAST_STEP)

over_specs = pytest.mark.parametrize(
    "spec",
    [RobotSpec(), RobotSpec.fast(), TURNING, WHEELED],
    ids=["1/60", "1/30", "turning", "wheeled"],
)


@pytest.mark.parametrize("trace", TRACES[::TRACE_STRIDE])
def test_recorded_episodes_are_reproduced(trace: dict[str, Any]) -> None:
    assert_as_recorded(env_of(trace, RigidBodyMotion(record_path=False)), trace)


@over_specs
def test_random_episodes_are_equal_on_both_backends(spec: RobotSpec) -> None:
    assert steps_differ(spec, MOVES, layouts=10) > MOVES / 8, "too few hits to compare"


@pytest.mark.filterwarnings("ignore:.*can keep")
@pytest.mark.parametrize(("robots", "joint_actions"), [(7, 60), (25, 30)])
def test_a_nominal_fleet_of_bodies_equals_a_fleet_on_the_grid(robots, joint_actions) -> None:
    stops = bodies_move_as_the_grid(robots, joint_actions, seed=robots)
    assert stops.total() == robots * joint_actions
    assert min(stops["free"], stops["wall"], stops["robot"]) > 0


def test_a_robot_moved_by_hand_continues_from_its_new_cell() -> None:
    env = WarehouseEnv(backend=RigidBodyMotion)
    env.step("E")
    last = DEFAULT_LAYOUT.open_cell(len(DEFAULT_LAYOUT.open_cells) - 1)
    env.state.robot_pos = last
    env.step("WAIT")
    assert env.state.robot_pos == last
    assert env.last_motion.path[0, 1:3] == pytest.approx((last[1] + 0.5, last[0] + 0.5))


def test_the_backend_passes_every_conformance_check() -> None:
    small = replace(WHEELED, cell_size=0.5, radius=0.15)
    run_conformance(lambda: RigidBodyMotion(small)).raise_for_failures()
