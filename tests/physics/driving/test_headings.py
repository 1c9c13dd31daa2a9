"""Robots that drive through turn: on the spot at corners, or while they drive."""

import math

import numpy as np
import pytest

from agents.mapf.execution import drive_through
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import Cell, Layout
from warehouse_core.world.generators import kiva_warehouse
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

HALL = Layout(["....."] * 5)
QUARTER = 1.5
TURNING = RobotSpec(turn_seconds=QUARTER)
RING = [(1, 1), (1, 2), (2, 2), (2, 1)]


def driven(spec: RobotSpec, *steps: list[Cell], seconds: float = 30) -> list[np.ndarray]:
    """Return the paths of robots that drive through the cells of joint steps in the hall."""
    motion = DrivingMotion(spec, path_every=1)
    motion.reset(HALL, steps[0], 0)
    for cells in steps[1:]:
        motion.extend(cells)
    outcomes = motion.drive(seconds)
    assert all(motion.ways().at_rest)
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


def test_a_robot_turns_before_its_first_move_and_where_its_way_turns_back() -> None:
    [path] = driven(TURNING, [(2, 2)], [(2, 1)], [(2, 2)])
    assert arrival(path) == pytest.approx(2 * (2 * QUARTER + 2), abs=0.1)


def test_robots_of_a_ring_turn_at_every_corner() -> None:
    """All cells of the ring are occupied, so that nobody can move unless all do."""
    steps = [RING[turn:] + RING[:turn] for turn in range(4)]
    paths = driven(TURNING, *steps, RING)
    # The first faces east; the one that is to go west turns round; then there are three corners.
    assert min(map(arrival, paths)) >= 4 * 2 + 3 * QUARTER
    assert max(map(arrival, paths)) <= 4 * 2 + 5 * QUARTER + 0.2


def test_a_robot_without_a_turning_time_turns_gradually_and_drives_as_if_it_did_not() -> None:
    [path] = driven(RobotSpec(), [(0, 0)], [(0, 1)], [(0, 2)], [(1, 2)], [(2, 2)])
    assert arrival(path) < 4 + 2
    _, x, _, heading = path.T
    assert 0 < np.diff(heading).max() <= math.pi * 1.001 / 60
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


def test_fleets_that_turn_execute_a_plan_without_hits() -> None:
    layout, starts, goals = kiva_warehouse()
    graph = Graph(layout)
    run = run_lifelong(graph, PIBT(graph), 128, 12, 1, starts, goals)
    execution = drive_through(layout, run.cells, RobotSpec(turn_seconds=0.5))
    assert execution.hits == 0
    assert execution.seconds > drive_through(layout, run.cells).seconds
