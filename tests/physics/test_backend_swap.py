"""One word swaps the backend, and nothing that an agent is told changes."""

from typing import Any

import pytest
from helpers.rigid_bodies import steps_differ
from helpers.traces import assert_as_recorded, env_of, over_traces

from warehouse_core import DEFAULT_LAYOUT, WarehouseEnv
from warehouse_core.conformance import run_conformance
from warehouse_core.motion.grid import GridMotion
from warehouse_physics import RigidBodyMotion, RobotSpec

MOVES = 10_000
"""Random actions made on both backends; the benchmarks make more."""


over_specs = pytest.mark.parametrize("spec", [RobotSpec(), RobotSpec.fast()], ids=["1/60", "1/30"])


@over_specs
@over_traces
def test_recorded_episodes_come_out_as_recorded(trace: dict[str, Any], spec: RobotSpec) -> None:
    env = env_of(trace, RigidBodyMotion(spec, record_path=False))
    assert_as_recorded(env, trace)


@over_specs
def test_random_layouts_and_actions_come_out_the_same(spec: RobotSpec) -> None:
    blocked = steps_differ(spec, MOVES // 2)
    assert blocked > MOVES / 2 / 8, "bumps are what is worth comparing"


def test_the_types_of_the_five_values_are_the_same_too() -> None:
    grid, physics = WarehouseEnv(), WarehouseEnv(backend=RigidBodyMotion)
    for action in ("E", "N", "PICK", "fly"):
        one, other = grid.step(action), physics.step(action)
        assert list(map(type, one)) == list(map(type, other))
        types = {name: type(value) for name, value in one[0].items()}
        assert {name: type(value) for name, value in other[0].items()} == types


def test_a_robot_that_is_put_elsewhere_starts_from_there() -> None:
    env = WarehouseEnv(backend=RigidBodyMotion)
    env.step("E")
    last = DEFAULT_LAYOUT.open_cell(len(DEFAULT_LAYOUT.open_cells) - 1)
    env.state.robot_pos = last
    env.step("WAIT")
    assert env.state.robot_pos == last
    assert env.last_motion.path[0, 1:3] == pytest.approx((last[1] + 0.5, last[0] + 0.5))


@pytest.mark.parametrize(
    "make_motion",
    [
        GridMotion,
        RigidBodyMotion,
        lambda: RigidBodyMotion(RobotSpec.fast()),
        lambda: RigidBodyMotion(RobotSpec(cell_size=0.5, radius=0.17)),
        lambda: RigidBodyMotion(RobotSpec(cell_size=2.0, radius=0.7, acceleration=0.5)),
        lambda: RigidBodyMotion(record_path=False),
    ],
    ids=["grid", "physics", "1/30 s", "small cells", "large cells", "no paths"],
)
def test_both_backends_pass_every_conformance_check(make_motion) -> None:
    run_conformance(make_motion).raise_for_failures()
