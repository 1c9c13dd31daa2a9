"""One word swaps the backend, and nothing that an agent is told changes."""

import random
from typing import Any

import pytest
from traces import assert_as_recorded, env_of, over_traces

from warehouse_core import DEFAULT_LAYOUT, WarehouseEnv, random_layout
from warehouse_core.conformance import run_conformance
from warehouse_core.grid_motion import GridMotion
from warehouse_physics import RigidBodyMotion, RobotSpec

MOVES = 10_000
"""Random actions made on both backends; the benchmarks make more."""

LAYOUTS = 20

ACTIONS = (*WarehouseEnv.ACTIONS, *"NESW" * 3, 0, 1, 2, 3, 99, "fly")

over_specs = pytest.mark.parametrize("spec", [RobotSpec(), RobotSpec.fast()], ids=["1/60", "1/30"])


def steps_differ(spec: RobotSpec, moves: int, layouts: int = LAYOUTS) -> int:
    """Step both backends side by side and return how many steps were blocked.

    Raises:
        AssertionError: one of the five values differs.
    """
    stream, blocked = random.Random(0), 0
    for seed in range(layouts):
        layout = random_layout(stream.randint(4, 12), stream.randint(4, 12), 0.25, seed=seed)
        limits = {"start_pos": layout.open_cell(0), "max_steps": 200, "battery": 190}
        grid = WarehouseEnv(layout, **limits)
        physics = WarehouseEnv(layout, **limits, backend=RigidBodyMotion(spec, record_path=False))
        for number in range(moves // layouts):
            if number % 150 == 0:
                randomize = number % 300 == 0
                expected = grid.reset(randomize, seed=number)
                assert physics.reset(randomize, seed=number) == expected
            action = stream.choice(ACTIONS)
            assert physics.step(action) == grid.step(action), (layout.rows, number, action)
            assert physics.last_motion.blocked == grid.last_motion.blocked
            blocked += grid.last_motion.blocked
            # A load changes the physics, so let the robot carry something half of the time.
            if number % 20 == 0:
                grid.state.has_item = physics.state.has_item = not grid.state.has_item
        assert physics.render() == grid.render()
    return blocked


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
