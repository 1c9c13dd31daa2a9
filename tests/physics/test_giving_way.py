"""Jams, queues and rings of robots that stop each other, and actions that are cut off."""

import math

import pytest
from helpers.physics_truth import differences_in_jams, jams, queue, straight_queue, winding_queue
from helpers.rigid_bodies import EAST, NORTH, STAY, WEST, together

from warehouse_core import Layout
from warehouse_physics import RigidBodyMotion, RobotSpec, rigid_body_motion
from warehouse_physics.giving_way import GivingWay
from warehouse_physics.robot import comes_closer
from warehouse_physics.robot_arena import RobotArena

SPEC = RobotSpec()

MOVES = 400
"""Robot moves in jams; the benchmarks make more."""


def test_heavily_loaded_jams_end_as_the_table_says() -> None:
    made, wrong, cut_off = differences_in_jams(MOVES)
    assert made >= MOVES
    assert (wrong, cut_off) == (0, 0)


@pytest.mark.parametrize(("seed", "actions"), [(8985, 5), (10506, 2)])
def test_a_light_robot_that_is_caught_behind_heavy_ones_gets_home(seed: int, actions: int) -> None:
    """The normal force leaves it there, and so does the full force without patience or detours."""
    *_, last = jams(seed, actions)
    assert [outcome[:2] for outcome, _, _ in last] == [(cell, stopped) for _, cell, stopped in last]
    assert not any(outcome.cut_off for outcome, _, _ in last)


@pytest.mark.parametrize("kilograms", [38, 90])
@pytest.mark.parametrize("time_step", [1 / 60])
def test_four_robots_in_a_passage_get_back_to_their_cells(kilograms, time_step) -> None:
    """The light robot 0 comes between the loaded robots 1 and 3, and is in the way of both."""
    spec = RobotSpec(
        payload_mass=kilograms, time_step=time_step, motor_force=max(60, 1.2 * kilograms)
    )
    cells, layout = [(2, 2), (1, 3), (1, 5), (1, 2)], Layout(["######", "......", "##.###"])
    loaded = [False, True, True, True]
    outcomes = together(layout, cells, [NORTH, EAST, WEST, EAST], spec, loaded)
    assert [outcome.cell for outcome in outcomes] == cells
    assert all(outcome.blocked and not outcome.cut_off for outcome in outcomes)


@pytest.mark.parametrize("make_queue", [straight_queue, winding_queue])
def test_a_blocked_queue_of_160_goes_back_as_fast_as_a_short_one(make_queue) -> None:
    short, long = (make_queue(robots) for robots in (16, 160))
    outcomes = queue(*long)
    assert [outcome.cell for outcome in outcomes] == long[1]
    assert [outcome.blocked for outcome in outcomes] == [True] * 159 + [False]
    assert not any(outcome.cut_off for outcome in outcomes)
    slowest = max(outcome.seconds for outcome in queue(*short))
    assert max(outcome.seconds for outcome in outcomes) == pytest.approx(slowest, rel=0.2)


def test_robots_that_drive_to_either_cell_of_a_stopped_robot_are_stopped_with_all_behind_them() -> (
    None
):
    """Robot 0 is stopped. 1 drives to its goal, 2 to its cell, 3 to the cell of 2, 4 elsewhere."""
    layout = Layout(["....", "....", "...."])
    cells, moves = [(0, 1), (0, 3), (1, 1), (1, 0), (2, 0)], [EAST, WEST, NORTH, EAST, EAST]
    robots = RobotArena(layout, cells, SPEC).robots
    for robot, displacement in zip(robots, moves, strict=True):
        robot.begin(displacement, False, SPEC.acceleration)
    robots[0].give_up()
    assert GivingWay(robots).move_on(0)
    assert [robot.action.gave_up for robot in robots] == [True, True, True, True, False]
    ends = [(robot.action.target[1], robot.action.target[0]) for robot in robots]
    homes = [(row + 0.5, col + 0.5) for row, col in cells]
    assert ends == [*homes[:4], (2.5, 1.5)]


def test_a_robot_that_only_a_wall_stopped_does_not_wait_for_others() -> None:
    """Robot 0 is stopped by the wall, and robot 1 drives away next to it."""
    layout, cells = Layout(["....", "...."]), [(0, 0), (1, 0)]
    stopped, free = together(layout, cells, [NORTH, EAST])
    assert stopped.seconds == together(layout, cells, [NORTH, STAY])[0].seconds < free.seconds


def test_robots_too_wide_to_pass_at_corners_are_refused_when_there_are_several() -> None:
    spec = RobotSpec(radius=0.201, cell_size=0.5)
    motion = RigidBodyMotion(spec)
    motion.reset(Layout([".."]), [(0, 0)], 0)
    with pytest.raises(ValueError, match=r"^radius is 0\.201; .* at most 0\.2 for 2"):
        motion.reset(Layout([".."]), [(0, 0), (0, 1)], 0)
    assert motion.advance([EAST], [False])[0].cell == (0, 1)


def test_an_action_that_takes_too_long_is_cut_off_and_says_so(monkeypatch) -> None:
    monkeypatch.setattr(rigid_body_motion, "MAX_SECONDS", 0.5)
    monkeypatch.setattr(rigid_body_motion, "MAX_MOVE_SECONDS", 1 / 6)
    motion = RigidBodyMotion(path_every=1)
    motion.reset(Layout(["....", "...."]), [(0, 0), (1, 3)], 0)
    driving, waiting = motion.advance([EAST, STAY], [False, False])
    assert (driving.cut_off, waiting.cut_off) == (True, False)
    assert driving.seconds == driving.path[-1, 0] == pytest.approx(40 / 60)
    assert driving.cell == (0, 0)
    # It brakes in the next action and returns to the middle of the cell that it is in.
    monkeypatch.undo()
    stopped = motion.advance([STAY, STAY], [False, False])[0]
    assert (stopped.cut_off, stopped.blocked) == (False, False)
    assert math.dist(stopped.path[-1, 1:3], (stopped.cell[1] + 0.5, 0.5)) < 1e-3


def test_a_straight_path_comes_closer_if_it_leads_past_the_other() -> None:
    assert comes_closer((-2.0, 0.5), (2.0, 0.5), 0.7)
    assert not comes_closer((-2.0, 0.8), (2.0, 0.8), 0.7)
    assert not comes_closer((-2.0, 0.0), (-1.0, 0.0), 0.7), "it stops before"
    assert comes_closer((-2.0, 0.0), (-0.6, 0.0), 0.7)
    assert not comes_closer((-0.6, 0.0), (-1.0, 0.0), 0.7), "bodies that touch may separate"
    assert comes_closer((-0.6, 0.0), (0.0, 1.0), 0.7)
    assert not comes_closer((-0.6, 0.0), (-0.6, 0.0), 0.7), "neither moves"
