"""How a robot judges a hit: whether it is in the way, and whether it blocks the robot."""

import pytest
from helpers.rigid_bodies import EAST, STAY, WEST

from warehouse_core import Cell, Layout
from warehouse_physics import RobotSpec
from warehouse_physics.arena import Hit
from warehouse_physics.robot import Robot
from warehouse_physics.robot_arena import RobotArena

SPEC = RobotSpec()


def robots_that(*moves: Cell) -> list[Robot]:
    """Return robots next to each other in a row, from the third cell on, that begin to move."""
    cells = [(0, 2 + col) for col in range(len(moves))]
    robots = RobotArena(Layout(["......"]), cells, SPEC).robots
    for robot, displacement in zip(robots, moves, strict=True):
        robot.begin(displacement, False, SPEC.acceleration)
        robot.set_off(0)
    return robots


WALLS = {
    "ahead": ((-1.0, 0.0), (2.9, 0.5), True),
    "askew": ((-0.8, 0.6), (2.9, 0.5), True),
    "from the corner": ((-0.7, 0.7), (2.9, 0.5), False),
    "rather from the side": ((-0.6, 0.8), (2.9, 0.5), False),
    "from behind": ((1.0, 0.0), (2.9, 0.5), False),
    "in the lane": ((-1.0, 0.0), (2.9, 0.99), True),
    "outside the lane": ((-1.0, 0.0), (2.9, 1.01), False),
    "on its other side": ((-1.0, 0.0), (2.9, -0.01), False),
    "before the goal": ((-1.0, 0.0), (3.49, 0.5), True),
    "beyond the goal": ((-1.0, 0.0), (3.51, 0.5), False),
}
"""Push and place of a hit, and whether the robot gives up."""


@pytest.mark.parametrize(("push", "point", "gives_up"), WALLS.values(), ids=WALLS)
def test_a_wall_is_in_the_way_if_it_reaches_into_the_lane_and_pushes_back(
    push: tuple[float, float], point: tuple[float, float], gives_up: bool
) -> None:
    """The robot drives from (2.5, 0.5) to (3.5, 0.5)."""
    (robot,) = robots_that(EAST)
    robot.meet(1, Hit(0, None, push, (0.3, 0.0), 1.0, point), None)
    assert robot.action.gave_up == gives_up
    assert robot.action.target == ((2.5, 0.5) if gives_up else (3.5, 0.5))


@pytest.mark.parametrize(
    ("others", "has_given_up", "gives_up"),
    [(EAST, False, False), (EAST, True, True), (STAY, False, True), (WEST, False, True)],
    ids=["drives away", "comes back", "waits", "head-on"],
)
def test_another_robot_is_in_the_way_unless_it_leaves_the_cell(
    others: Cell, has_given_up: bool, gives_up: bool
) -> None:
    robot, other = robots_that(EAST, others)
    if has_given_up:
        other.give_up()
    robot.meet(1, Hit(0, 1, (-1.0, 0.0), (0.3, 0.0), 1.0, (3.0, 0.5)), other)
    assert (robot.action.gave_up, robot.action.has_met) == (gives_up, True)


@pytest.mark.parametrize(
    ("displacement", "x", "touches", "gives_up", "is_blocked"),
    [
        (EAST, 2.9, True, False, True),
        (EAST, 2.9, False, True, True),
        (EAST, 2.9, False, False, False),
        (EAST, 3.1, True, True, False),
        (EAST, 4.1, True, False, True),
        (STAY, 3.1, True, False, False),
    ],
    ids=[
        "touched",
        "gave up",
        "out of time",
        "at its goal",
        "pushed past it",
        "pushed while waiting",
    ],
)
def test_a_robot_is_blocked_if_something_kept_it_from_another_cell(
    displacement: Cell, x: float, touches: bool, gives_up: bool, is_blocked: bool
) -> None:
    """The robot begins at (2.5, 0.5) and ends at (``x``, 0.5)."""
    robot, other = robots_that(displacement, EAST)
    if touches:
        robot.meet(1, Hit(0, 1, (-1.0, 0.0), (0.3, 0.0), 0.5, (3.0, 0.5)), other)
    if gives_up:
        robot.give_up()
    robot.position = x, 0.5
    assert robot.is_blocked() == is_blocked
