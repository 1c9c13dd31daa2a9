"""The task under continuous control: stations, rewards, battery, ends and disturbances."""

import numpy as np
import pytest
from helpers.drive_rows import WIDE, rows_on

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError, WarehouseEnv
from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.drive import DriveEnv
from warehouse_physics.energy import move_joules

AISLE = Layout(["########", "#..P..D#", "########"])
STILL = np.zeros((1, 2))


def carry(rows, x, has_item):
    """Drive along an aisle to ``x`` until the load changes; return the step, and ``stood`` before.

    The controller is proportional, so the robot stands when it is near.
    """
    for _ in range(200):
        stood = float(rows.stood[0])
        off = x - rows.state.positions[0, 0]
        step = rows.step(np.array([[np.clip(off, -1, 1), 0.0]]))
        if rows.has_item[0] != has_item:
            return step, stood
    raise AssertionError("the robot has neither picked nor dropped")


def test_seeds_draw_the_same_tasks_as_on_the_grid():
    grid, env = WarehouseEnv(), DriveEnv()
    for seed in range(20):
        grid.reset(randomize=True, seed=seed)
        env.reset(seed=seed)
        assert (env.layout, env.cell) == (grid.layout, grid.state.robot_pos)
        assert env.observe() == grid.observe()


def test_a_robot_picks_and_drops_after_it_has_stood_in_the_cell():
    rows = rows_on(AISLE, start=(1, 1))
    step, stood = carry(rows, 3.5, has_item=False)
    assert stood == pytest.approx(RobotSpec().dwell - 0.1)
    assert step.rewards[0] == pytest.approx(5.0 - 0.1 * 0.1 / 2.0, abs=1e-3)
    assert rows.bodies.body(0).mass == 70.0
    assert not step.terminated[0]
    step, _ = carry(rows, 6.5, has_item=True)
    assert step.terminated[0]
    assert step.rewards[0] == pytest.approx(10.0 - 0.005, abs=1e-3)
    assert rows.bodies.body(0).mass == 50.0


def test_a_robot_that_drives_or_turns_through_a_station_picks_nothing():
    rows = rows_on(AISLE, RobotSpec(drive="differential"), start=(1, 3))
    for _ in range(30):
        rows.step(np.array([[0.0, 0.5]]))
    assert not rows.has_item[0]
    for _ in range(30):
        rows.step(STILL)
    assert rows.has_item[0]


def test_a_hit_costs_as_much_as_its_impulse():
    rows = rows_on(AISLE, start=(1, 1))
    total, impulse = 0.0, 0.0
    for _ in range(20):
        step = rows.step(np.array([[-1.0, 0.0]]))
        total, impulse = total + step.rewards[0], impulse + step.impulses[0]
    # It gains sqrt(2 * 1 m/s² * 0.15 m) on its way to the wall.
    assert impulse == pytest.approx(50 * np.sqrt(0.3), rel=0.05)
    assert total == pytest.approx(-1.0 * impulse / 50 - 20 * 0.005)


def test_time_and_battery_end_an_episode():
    short = rows_on(AISLE, start=(1, 1), max_seconds=0.5)
    assert [bool(short.step(STILL).truncated[0]) for _ in range(5)] == [False] * 4 + [True]
    weak = rows_on(AISLE, start=(1, 1), battery=5.0)  # the idle power is 20 W
    ends = [bool(weak.step(STILL).truncated[0]) for _ in range(3)]
    assert ends == [False, False, True]


def test_a_robot_that_stands_on_a_charger_is_charged():
    layout = Layout(["########", "#CP...D#", "########"])
    spec = RobotSpec()
    rows = rows_on(layout, spec, start=(1, 1), battery=10_000.0)
    rows.batteries[0] = 5_000.0
    rows.step(STILL)
    gained = 10 * move_joules(spec, loaded=True) * 0.1 / spec.move_seconds(False)
    assert rows.batteries[0] == pytest.approx(5_000 - 2.0 + gained)
    rows.batteries[0] = 9_999.0
    rows.step(STILL)
    assert rows.batteries[0] == 10_000.0


def test_a_loaded_robot_is_slower():
    rows = rows_on(AISLE, start=(1, 3))
    for _ in range(12):
        rows.step(STILL)
    assert rows.has_item[0]
    rows.step(np.array([[1.0, 0.0]]))
    spec = RobotSpec()
    assert rows.state.velocities[0, 0] == pytest.approx(
        0.1 * spec.attainable_acceleration(loaded=True)
    )


def test_noise_depends_on_the_seed_of_the_row():
    noisy = Disturbances(actuation_noise=0.2)
    one, other = (rows_on(rows=3, disturbances=noisy) for _ in range(2))
    for rows in (one, other):
        for _ in range(20):
            rows.step(np.full((3, 2), 0.5))
    assert (one.state.positions == other.state.positions).all()
    assert len({tuple(each) for each in one.state.positions.tolist()}) == 3


def test_drag_that_varies_is_felt_from_cell_to_cell():
    rows = rows_on(disturbances=Disturbances(drag_spread=0.9, motor_strength=0.15))
    speeds = []
    for _ in range(80):
        rows.step(np.array([[1.0, 0.0]]))
        speeds.append(float(rows.state.velocities[0, 0]))
    gains = np.diff(speeds)
    assert gains.min() < 0 < gains.max()


def test_odometry_errs_but_does_not_change_the_motion():
    exact, wrong = rows_on(rays=4), rows_on(rays=4, disturbances=Disturbances(odometry=0.1))
    for _ in range(30):
        exact.step(np.array([[1.0, 0.2]]))
        wrong.step(np.array([[1.0, 0.2]]))
    assert (exact.state.positions == wrong.state.positions).all()
    off = np.hypot(*(wrong.poses() - exact.poses())[0, :2])
    assert 0.01 < off < 2


def test_a_layout_with_other_walls_is_refused():
    rows = rows_on(AISLE, start=(1, 1))
    with pytest.raises(LayoutError, match="the same walls"):
        rows.begin([0], [0], DEFAULT_LAYOUT)
    rows.begin([0], [0], AISLE.with_stations((1, 5), (1, 2)), (1, 4))
    assert rows.goals().tolist() == [[5.5, 1.5]]
    assert rows.state.positions.tolist() == [[4.5, 1.5]]


def test_without_a_station_the_goal_is_the_start():
    rows = rows_on(WIDE)
    assert rows.goals().tolist() == [[30.5, 30.5]]


SPECS = [
    RobotSpec(),
    RobotSpec(drive="differential"),
    RobotSpec(radius=0.1, top_speed=2.5, acceleration=20.0, motor_force=5000.0),
    RobotSpec(radius=0.45, top_speed=3.0, acceleration=5.0, motor_force=500.0, mass=20.0),
    RobotSpec(drive="differential", track=0.1, acceleration=4.0, motor_force=400.0),
    RobotSpec(mass=5.0, payload_mass=200.0, motor_force=2000.0, acceleration=8.0),
]


@pytest.mark.parametrize("spec", SPECS)
def test_no_robot_sinks_deep_into_walls_or_leaves_the_floor(spec):
    layout = Layout(["######", "#..#.#", "#P...#", "#.#.D#", "######"])
    rows = rows_on(layout, spec, rows=40, start=(1, 1), randomize=True)
    walls = np.array([list(row) for row in layout.rows]) == "#"
    boxes = np.argwhere(walls)[:, ::-1].astype(float)
    actions = np.random.default_rng(0).uniform(-1, 1, (20, 40, 2)).round()
    deepest = 0.0
    for number in range(200):
        rows.step(actions[number // 10])
        places = rows.state.positions[:, None]
        nearest = np.clip(places, boxes, boxes + 1)
        gaps = np.hypot(*np.moveaxis(places - nearest, 2, 0)).min(axis=1)
        deepest = max(deepest, float((spec.radius - gaps).max()))
    assert 0 < deepest < 0.05 * spec.radius
