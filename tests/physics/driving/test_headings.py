"""Turns of robots that drive through: on the spot at corners, or while they drive."""

import math

import numpy as np
import pytest

from agents.mapf.execution import drive_through
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import Cell, Layout
from warehouse_core.world.generators import kiva_warehouse
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec, Stop

HALL = Layout(["....."] * 5)
QUARTER = 1.5
TURNING = RobotSpec(turn_seconds=QUARTER)
WHEELED = RobotSpec(drive="differential")
RING = [(1, 1), (1, 2), (2, 2), (2, 1)]


def driven(spec: RobotSpec, *steps: list[Cell], seconds: float = 30) -> list[np.ndarray]:
    """Return the paths of robots that drive through the cells of joint steps in the hall."""
    motion = DrivingMotion(spec, path_every=1)
    motion.reset(HALL, steps[0], 0)
    for cells in steps[1:]:
        motion.extend(cells)
    outcomes = motion.drive(seconds)
    assert all(motion.routes().at_rest)
    assert not any(outcome.contacts for outcome in outcomes)
    return [outcome.path for outcome in outcomes]


def arrival(path: np.ndarray) -> float:
    moves = np.abs(np.diff(path[:, 1:3], axis=0)).max(axis=1) > 1e-5
    return float(path[1:][moves][-1, 0])


def test_a_robot_turns_in_the_middle_of_a_corner_cell() -> None:
    [path] = driven(TURNING, [(0, 0)], [(0, 1)], [(0, 2)], [(1, 2)], [(2, 2)])
    # Two cells take 3 s from rest to rest.
    assert arrival(path) == pytest.approx(3 + QUARTER + 3, abs=0.1)
    clock, x, y, heading = path.T
    turns = (heading > 0) & (heading < math.pi / 2)
    assert np.ptp(clock[turns]) == pytest.approx(QUARTER, abs=0.05)
    assert x[turns] == pytest.approx(2.5, abs=2e-3)
    assert y[turns] == pytest.approx(0.5, abs=2e-3)
    assert heading[x < 2.49].max() == 0
    assert heading[y > 0.51].min() == pytest.approx(math.pi / 2)


def test_a_robot_turns_before_its_first_move_and_where_its_route_turns_back() -> None:
    [path] = driven(TURNING, [(2, 2)], [(2, 1)], [(2, 2)])
    assert arrival(path) == pytest.approx(2 * (2 * QUARTER + 2), abs=0.1)


def test_robots_of_a_ring_turn_at_every_corner() -> None:
    """All cells of the ring are occupied, so that no robot can move unless all of them do."""
    steps = [RING[turn:] + RING[:turn] for turn in range(4)]
    paths = driven(TURNING, *steps, RING)
    # The first robot faces east, and the one that goes west turns round. Three corners follow.
    assert min(map(arrival, paths)) >= 4 * 2 + 3 * QUARTER
    assert max(map(arrival, paths)) <= 4 * 2 + 5 * QUARTER + 0.2


def test_a_robot_without_a_turning_time_faces_the_direction_of_its_motion() -> None:
    [path] = driven(RobotSpec(), [(0, 0)], [(0, 1)], [(0, 2)], [(1, 2)], [(2, 2)])
    assert arrival(path) < 4 + 2
    _, x, y, heading = path.T
    moves = np.hypot(np.diff(x), np.diff(y)) > 0.1 / 60
    directions = np.arctan2(np.diff(y), np.diff(x))
    assert heading[1:][moves] == pytest.approx(directions[moves], abs=0.15)
    assert heading[x < 1.99].max() == 0
    assert heading[-1] == pytest.approx(math.pi / 2)


def test_a_robot_that_is_stopped_does_not_turn() -> None:
    motion = DrivingMotion(TURNING, Disturbances(stops=(Stop(0, 0.5, 5.0),)), path_every=1)
    motion.reset(HALL, [(0, 0)], 0)
    motion.extend([(1, 0)])
    [outcome] = motion.drive(12)
    clock, _, _, heading = outcome.path.T
    assert np.ptp(heading[(clock > 0.6) & (clock < 5.4)]) == 0
    assert 0 < heading[clock > 0.6][0] < math.pi / 2
    assert arrival(outcome.path) == pytest.approx(5 + QUARTER + 2, abs=0.1)


def test_a_robot_with_two_wheels_turns_at_corners_with_the_torque_of_its_motor() -> None:
    [path] = driven(WHEELED, [(0, 0)], [(0, 1)], [(0, 2)], [(1, 2)], [(2, 2)])
    quarter = WHEELED.turn_substeps(1) * WHEELED.time_step
    assert arrival(path) == pytest.approx(3 + quarter + 3, abs=0.1)
    clock, x, y, heading = path.T
    turns = (heading > 1e-3) & (heading < math.pi / 2 - 1e-3)
    assert np.ptp(clock[turns]) == pytest.approx(quarter, rel=0.1)
    assert x[turns] == pytest.approx(2.5, abs=2e-3)
    assert y[turns] == pytest.approx(0.5, abs=2e-3)
    rates = np.diff(heading) / WHEELED.time_step
    most = WHEELED.turning_acceleration(loaded=False) / WHEELED.wheel_arm
    assert np.abs(np.diff(rates)).max() <= most * WHEELED.time_step * 1.001
    assert rates.max() == pytest.approx(math.sqrt(math.pi / 2 * most), rel=0.05)


def test_a_turn_of_a_robot_that_drives_through_costs_what_it_costs_one_that_stops() -> None:
    joules = []
    for motion in (DrivingMotion(WHEELED), RigidBodyMotion(WHEELED)):
        motion.reset(HALL, [(2, 2)], 0)
        costs = []
        for target, step in (((2, 3), (0, 1)), ((3, 3), (1, 0))):
            if isinstance(motion, DrivingMotion):
                motion.extend([target])
                [outcome] = motion.drive(8)
            else:
                [outcome] = motion.advance([step], [False])
            costs.append(outcome.joules - WHEELED.idle_power * outcome.seconds)
        joules.append(costs)
    through, stopping = joules
    assert through[0] == pytest.approx(stopping[0], rel=0.03)
    assert through[1] - through[0] == pytest.approx(stopping[1] - stopping[0], rel=0.05)


def test_a_robot_of_two_wheels_off_its_line_gets_back_only_while_it_drives() -> None:
    motion = DrivingMotion(WHEELED, path_every=1)
    motion.reset(HALL, [(2, 0)], 0)
    motion._driver._arena.bodies[0].position = (0.5, 2.6)
    waiting = motion.drive(2)[0].path
    assert np.ptp(waiting[1:, 1:3], axis=0) == pytest.approx((0.0, 0.0))
    for col in range(1, 5):
        motion.extend([(2, col)])
    _, x, y, _ = motion.drive(8)[0].path.T
    assert (x[-1], y[-1]) == pytest.approx((4.5, 2.5), abs=2e-3)
    assert (np.abs(np.diff(y)) <= 0.2001 * np.abs(np.diff(x)) + 1e-9).all()


def test_tyres_hold_a_robot_that_drives_through_on_its_line_unless_the_floor_is_slippery() -> None:
    """The test puts a robot in the way, which is hit from the side."""
    asides, impulses = [], []
    for slippery in ([], [(2, 1), (2, 2)]):
        motion = DrivingMotion(WHEELED, Disturbances(slippery=slippery, grip=0.3), path_every=1)
        motion.reset(HALL, [(2, 1), (4, 2)], 0)
        motion._driver._arena.bodies[1].position = (2.5, 3.15)
        motion._driver._arena.bodies[1].velocity = (0.0, -0.5)
        motion._driver._arena.face(1, -math.pi / 2)
        motion.extend([(2, 2), (4, 2)])
        still, other = motion.drive(3)
        assert still.contacts
        impulses.append(other.contacts[0].impulse)
        asides.append(np.ptp(still.path[:, 2]))
    assert asides[0] < 1e-3 < 0.01 < asides[1]
    assert impulses[0] > 1.5 * impulses[1] > 0


def test_a_disturbed_fleet_on_two_wheels_executes_a_plan_without_hits() -> None:
    layout, starts, goals = kiva_warehouse()
    graph = Graph(layout)
    run = run_lifelong(graph, PIBT(graph), 30, 10, 1, starts, goals)
    trouble = Disturbances(0.1, slippery=layout.cells(starts[3:9:3]), grip=0.1, drag_spread=0.3)
    assert drive_through(layout, run.cells, WHEELED, trouble).hits == 0


def test_a_robot_of_two_wheels_that_has_to_go_back_drives_backwards() -> None:
    motion = DrivingMotion(WHEELED, path_every=1)
    motion.reset(HALL, [(0, 0), (0, 1)], 0)
    motion.extend([(0, 1), (0, 2)])
    motion.drive(0.8)
    motion.fail(1)
    follower, failed = motion.drive(8)
    assert follower.path[0, 1] > 0.7
    assert follower.path[-1, 1:] == pytest.approx((0.5, 0.5, 0.0), abs=2e-3)
    assert np.ptp(follower.path[:, 3]) == 0
    assert not follower.contacts + failed.contacts
