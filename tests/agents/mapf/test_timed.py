"""Plans with the seconds that corners take."""

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.mapf.execution import drive_through
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.planner import MotionPlanner, Situation
from agents.mapf.timed import HELD, Clocks, Follower, Pace, TimedPlanner, pace_of
from agents.mapf.windows import WindowedPlanner
from warehouse_core import GridMotion, Layout, shelf_layout
from warehouse_core.motion.base import cell_steps_of
from warehouse_core.world.tables import Integers
from warehouse_physics import DrivingMotion, RobotSpec

ROOM = Graph(Layout(["." * 6] * 4))
SHELVES = shelf_layout(2, 3, aisle=1, pickups=4, dropoffs=2, seed=1)


def test_bodies_say_what_corners_take() -> None:
    light, heavy = RobotSpec(payload_mass=0.0), RobotSpec()
    assert pace_of(light).half_turn == pytest.approx(1.0, abs=0.05), "it brakes and speeds up"
    assert 0 < pace_of(light).corner < pace_of(heavy).corner < pace_of(heavy).half_turn
    wheels = pace_of(RobotSpec(drive="differential"))
    assert wheels.corner > pace_of(heavy).half_turn, "it stops, turns and speeds up"
    assert pace_of(RobotSpec(top_speed=0.5)).half_turn < pace_of(heavy).half_turn


def test_clocks_count_corners_and_those_who_wait_for_late_robots() -> None:
    clocks = Clocks(ROOM, 2, Pace(0.25, 1.0))

    def after(*cells: tuple[int, int]) -> list[float]:
        before, now = (np.array(each) for each in zip(*cells, strict=True))
        clocks.add(before, now)
        return list(clocks.late.tolist())

    assert after((1, 2), (0, 1)) == [0.0, 0.0]
    assert after((2, 8), (1, 2)) == [0.25, 0.25], "the first turns, and the other is behind it"
    assert after((8, 2 + 12), (2, 3)) == [0.25, 0.25]
    assert after((14, 8), (3, 3)) == [1.25, 0.0], "one turns back, and the other waits"
    assert after((8, 8), (3, 9)) == [0.25, 0.25]
    assert after((8, 7), (9, 8)) == [0.5, 0.5], "the second turns into the cell of the late one"


def test_a_late_robot_stays_for_a_step_and_one_without_corners_does_not() -> None:
    walls = Layout(["..####", "#..###", "##..##", "###..#", "####.."])
    for layout, goal, waits in (walls, 29, 3), (Layout(["." * 10]), 9, 0):
        planner, cells = TimedPlanner(Graph(layout)), [0]
        while cells[-1] != goal:
            cells += planner.next_cells(situation(cells[-1:], [goal])).tolist()
        assert cells.count(cells[0]) == 1
        assert np.count_nonzero(np.diff(cells) == 0) == pytest.approx(waits, abs=1)


def test_the_motion_of_a_fleet_says_what_to_count() -> None:
    planner = TimedPlanner(Graph(SHELVES), seed=3)
    assert isinstance(planner, MotionPlanner)
    planner.plan_for(DrivingMotion())
    assert planner.graph.turn_cost == pytest.approx(pace_of(RobotSpec()).corner)
    planner.plan_for(GridMotion())
    assert planner.graph.turn_cost == 0
    same = WindowedPlanner(Graph(SHELVES), seed=3)
    runs = [run_lifelong(Graph(SHELVES), each, 8, 20, 3).cells for each in (planner, same)]
    assert (runs[0] == runs[1]).all(), "on the grid nobody loses time"


def test_bodies_keep_the_times_of_a_timed_plan() -> None:
    steps, robots = 30, 10
    late = {}
    for name, kind in (("timed", TimedPlanner), ("windowed", WindowedPlanner)):
        run = run_lifelong(Graph(SHELVES), kind(Graph(SHELVES), seed=1), robots, steps, 1)
        driven = drive_through(SHELVES, run.cells)
        assert driven.hits == 0
        late[name] = driven.seconds - steps
    assert late["timed"] < 0.5 * late["windowed"]


def test_a_motion_says_how_many_steps_a_cell_takes() -> None:
    assert cell_steps_of(GridMotion()) == 1
    assert cell_steps_of(DrivingMotion(period=0.25)) == pytest.approx(4)
    assert cell_steps_of(DrivingMotion(RobotSpec(top_speed=0.5))) == pytest.approx(1)


class Counting(WindowedPlanner):
    """Counts the plans that it makes."""

    plans = 0

    def next_cells(self, situation: Situation) -> Integers:
        """Return the next cells of one more plan."""
        self.plans += 1
        return super().next_cells(situation)


def follower() -> tuple[Follower, Counting]:
    """Return what follows plans in quarters of a step, and the planner of these."""
    windows = Counting(ROOM, seed=1)
    return Follower(windows, 4), windows


def test_robots_go_on_in_the_order_of_a_plan_when_they_have_room() -> None:
    following, windows = follower()
    first = following.next_cells(situation([0, 1], [5, 5 + 6], stays=[0]))
    assert first[0] == 0
    assert following.plan_of(1)[0] == first[1] != 1
    then = following.next_cells(situation(first, [5, 5 + 6], stays=[1]))
    assert (then[0] != 0, then[1]) == (True, first[1])
    assert [bool(following.plan_of(robot)) for robot in range(3)] == [True, True, False]
    assert windows.plans == 1
    following.next_cells(situation(then, [5, 4 + 6], stays=[0, 1]))
    assert windows.plans == 2, "a goal has changed"
    for _ in range(4):
        following.next_cells(situation(then, [5, 4 + 6], stays=[0, 1]))
    assert windows.plans == 3, "the time of a cell has passed"


def test_a_motion_in_short_steps_is_followed() -> None:
    planner = TimedPlanner(ROOM)
    planner.plan_for(DrivingMotion(period=0.25))
    planner.next_cells(situation([0], [5], stays=[0]))
    assert planner.plan_of(0) == [0, 1, 2, 3, 4, 5]
    planner.reset()
    assert planner.plan_of(0) == []


def test_robots_that_are_elsewhere_or_others_are_planned_for_anew() -> None:
    following, windows = follower()
    following.next_cells(situation([0], [5]))
    assert following.next_cells(situation([12], [5])).tolist() in ([6], [13])
    assert following.next_cells(situation([0, 5], [5, 0]))[0] in (1, 6)
    assert windows.plans == 3


def test_nobody_enters_a_cell_that_is_closed_between_two_plans() -> None:
    following, windows = follower()
    [after] = following.next_cells(situation([0], [5], stays=[0])).tolist()
    to = following.plan_of(0)[1]
    assert following.next_cells(situation([after], [5], closed=[to])).tolist() == [after]
    assert following.next_cells(situation([after], [5])).tolist() == [to]
    assert windows.plans == 1


def test_who_is_held_for_long_is_planned_around() -> None:
    corridor = Graph(Layout(["....."]))
    windows = Counting(corridor, seed=1)
    following, waits = Follower(windows, 4), situation([1, 0], [4, 3], stays=[0, 1])
    expected = []
    for _ in range(4 * (HELD + 2)):
        following.next_cells(waits)
        expected.append(int(windows.planned_cells[0, 1]))
    assert expected[0] == 1, "it has just moved"
    assert 2 in expected, "it should have room by now"
    assert expected[-1] == 1, "it is held"
