"""Until when a robot has a leader at a cell, and which cells of its way come next."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.driving.dependencies import Dependencies
from warehouse_physics.driving.leaders import NOWHERE, Leaders, straight_distance
from warehouse_physics.driving.limits import Limits

SPEC = RobotSpec()


@pytest.fixture
def queue() -> tuple[Dependencies, Leaders]:
    """Return the ways and leaders of two robots that go three cells east, one behind the other."""
    ways = Dependencies([(0, 0), (0, 1)])
    for col in range(1, 4):
        ways.extend([(0, col), (0, col + 1)])
    return ways, Leaders(SPEC, ways, Limits(SPEC, 2, Disturbances()))


def test_a_leader_holds_a_cell_until_its_body_has_left_room_for_another(queue) -> None:
    ways, leaders = queue
    before, apart = (np.array([0.0, straight_distance(SPEC) + by]) for by in (-0.001, 0.001))
    leaders.find(0, before)
    assert leaders.nodes[0, :2].tolist() == [1, 2]
    leaders.drop(before)
    assert leaders.nodes[0, :2].tolist() == [1, 2]
    leaders.drop(apart)
    assert leaders.nodes[0, :2].tolist() == [2, 3]
    leaders.drop(apart + 2)
    assert set(leaders.nodes.ravel().tolist()) == {NOWHERE}
    leaders = Leaders(SPEC, ways, Limits(SPEC, 2, Disturbances()))
    leaders.find(0, apart)
    assert leaders.nodes[0, 0] == 2, "a cell that a leader has left is not waited for"


@pytest.mark.parametrize(("radius", "beyond"), [(0.2, 0.41), (0.35, 0.738)])
def test_a_robot_that_cuts_its_next_corner_is_left_more_room(radius: float, beyond: float) -> None:
    """It is a diameter away in a straight line while it is on the arc, which begins at 0.5."""
    spec = replace(SPEC, radius=radius)
    assert straight_distance(spec) == pytest.approx(beyond, abs=1e-3)
    u = max(beyond - 0.5, 0.0)
    assert beyond - u * u / 2 == pytest.approx(2 * radius + 0.01, abs=1e-3)
    assert straight_distance(replace(spec, turn_seconds=1.0)) == pytest.approx(2 * radius + 0.01)


def test_the_first_robot_of_a_queue_has_no_leader(queue) -> None:
    leaders = queue[1]
    leaders.find(1, np.zeros(2))
    assert set(leaders.nodes[1].tolist()) == {NOWHERE}
