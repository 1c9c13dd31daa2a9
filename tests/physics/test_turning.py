"""Robots that turn on the spot before they drive in another direction."""

import math

import numpy as np
import pytest
from helpers.rigid_bodies import EAST, LEDGE, NORTH, SOUTH, STAY, WEST, motion_in, move, together

from warehouse_core import Cell, Layout
from warehouse_physics import RigidBodyMotion, RobotSpec

HALL = Layout(["....."] * 5)
QUARTER = 1.5
TURNING = RobotSpec(turn_seconds=QUARTER)
MOVE = RobotSpec().move_seconds(loaded=False)


def headings_of(path: np.ndarray) -> np.ndarray:
    return np.unwrap(path[:, 3])


@pytest.mark.parametrize(
    ("displacement", "quarters"), [(EAST, 0), (SOUTH, 1), (NORTH, -1), (WEST, 2)]
)
def test_a_robot_turns_on_the_spot_in_the_shorter_direction_and_then_drives(
    displacement: Cell, quarters: int
) -> None:
    outcome = move(motion_in(HALL, (2, 2), TURNING, path_every=1), displacement)
    turning = abs(quarters) * QUARTER
    assert outcome.seconds == pytest.approx(turning + MOVE, abs=0.02)
    assert outcome.cell == (2 + displacement[0], 2 + displacement[1])
    clock, x, y, _ = outcome.path.T
    turned = headings_of(outcome.path)
    assert np.ptp(x[clock <= turning]) == np.ptp(y[clock <= turning]) == 0
    assert abs(turned[-1]) == pytest.approx(abs(quarters) * math.pi / 2)
    if abs(quarters) == 1:
        assert turned[-1] == pytest.approx(quarters * math.pi / 2)
    steady = turned[-1] * np.clip(clock / max(turning, 1e-9), 0, 1)
    assert turned == pytest.approx(steady, abs=math.pi / 2 / QUARTER / 30)


def test_the_next_move_in_the_same_direction_needs_no_turn_and_waiting_needs_none() -> None:
    motion = motion_in(HALL, (2, 2), TURNING)
    first, waiting, second = (move(motion, step) for step in (SOUTH, STAY, SOUTH))
    assert first.seconds == pytest.approx(second.seconds + QUARTER)
    assert waiting.seconds == TURNING.dwell
    assert np.ptp(waiting.path[:, 3]) == np.ptp(second.path[:, 3]) == 0


def test_after_a_hit_a_robot_drives_back_in_reverse() -> None:
    motion = motion_in(LEDGE, (0, 0), TURNING)
    blocked = move(motion, SOUTH)
    assert blocked.blocked
    assert blocked.path[-1, 3] == pytest.approx(math.pi / 2)
    assert np.diff(headings_of(blocked.path)).min() >= 0
    again = move(motion, SOUTH)
    assert again.seconds == pytest.approx(blocked.seconds - QUARTER, abs=0.02)
    assert move(motion, NORTH).seconds == pytest.approx(again.seconds + 2 * QUARTER, abs=0.02)


def test_a_turn_costs_the_idle_power() -> None:
    straight, aside = (move(motion_in(HALL, (2, 2), TURNING), step) for step in (EAST, SOUTH))
    assert aside.joules - straight.joules == pytest.approx(TURNING.idle_power * QUARTER)


def test_all_that_move_set_off_together_after_the_longest_turn() -> None:
    """In a ring, one robot turns round and one need not turn; another robot waits elsewhere."""
    ring = [(1, 1), (1, 2), (2, 2), (2, 1)]
    moves = [EAST, SOUTH, WEST, NORTH]
    *movers, waiting = together(HALL, [*ring, (4, 4)], [*moves, STAY], TURNING, path_every=1)
    assert [outcome.cell for outcome in movers] == [*ring[1:], ring[0]]
    assert not any(outcome.contacts for outcome in movers)
    starts = [
        outcome.path[np.hypot(*(outcome.path[:, 1:3] - outcome.path[0, 1:3]).T) > 0][0, 0]
        for outcome in movers
    ]
    assert starts == [pytest.approx(2 * QUARTER, abs=0.05)] * 4
    assert len(set(starts)) == 1
    assert {outcome.seconds for outcome in movers} == {movers[0].seconds}
    assert waiting.seconds == TURNING.dwell


def test_a_robot_placed_anew_faces_east() -> None:
    batch = RigidBodyMotion(TURNING).batch([HALL])
    west, east, south = (np.array([action]) for action in (3, 1, 2))
    batch.place(np.array([0]), np.array([12]))
    empty = np.zeros(1, np.bool_)
    there = batch.advance(west, empty).seconds[0]
    assert there == pytest.approx(2 * QUARTER + MOVE, abs=0.02)
    batch.place(np.array([0]), np.array([12]))
    assert batch.advance(east, empty).seconds[0] == pytest.approx(there - 2 * QUARTER)
    assert batch.advance(south, empty).seconds[0] == pytest.approx(there - QUARTER)
