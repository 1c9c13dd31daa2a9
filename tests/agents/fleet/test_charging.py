"""Turns of robots at chargers."""

import numpy as np
import pytest

from agents.fleet.charging import (
    INTO_CHARGER,
    NONE,
    QUEUE_DISTANCE,
    Chargers,
    Needs,
    costs_around_chargers,
    use_and_charge,
)
from agents.fleet.travel import TravelTimes
from agents.mapf.graph import Graph
from warehouse_core import FleetEnv, Layout
from warehouse_core.fleet import Battery
from warehouse_physics import DrivingMotion, RigidBodyMotion, RobotSpec

pytestmark = pytest.mark.filterwarnings("ignore:.*can keep")

HALL = Layout(["C" + "." * 28 + "C"])
"""Cell numbers are the columns; the chargers are at 0 and 29."""


def chargers_of(robots: int, layout: Layout = HALL, battery: int | Battery = 200) -> Chargers:
    env = FleetEnv(layout, robots, battery=battery)
    return Chargers(env, TravelTimes(layout))


def needs(cells: list[int], battery: list[float], **changed: object) -> Needs:
    robots = len(cells)
    values = {"may_go": np.ones(robots, np.bool_), "limits": np.zeros(robots), **changed}
    return Needs(np.array(cells), np.array(battery, np.float64), **values)  # type: ignore[arg-type]


def test_a_robot_charges_in_time_until_it_is_nearly_full() -> None:
    chargers, cell, battery = chargers_of(1), np.array([8]), 100.0
    chargers.update(needs([8], [battery]))
    assert chargers.goals(cell).tolist() == [NONE]
    while chargers.turn[0] == NONE:
        battery -= 1
        chargers.update(needs([8], [battery]))
    assert 60 < battery < 90
    assert chargers.goals(cell).tolist() == [0]
    assert not chargers.charging(cell)[0]
    chargers.update(needs([0], [189]))
    assert chargers.charging(np.array([0]))[0]
    chargers.update(needs([0], [190]))
    assert chargers.turn.tolist() == [NONE]


def test_a_robot_leaves_at_the_knee_from_which_on_charging_is_slow() -> None:
    for knee, full in ((0.8, 160), (0.5, 140), (0.99, 190)):
        chargers = chargers_of(1, battery=Battery(200, knee=knee))
        chargers.update(needs([0], [30]))
        chargers.update(needs([0], [full - 1]))
        assert chargers.charging(np.array([0]))[0]
        chargers.update(needs([0], [full]))
        assert chargers.turn.tolist() == [NONE]


def test_a_heavy_robot_counts_with_what_its_own_body_needs() -> None:
    heavy = RobotSpec(mass=400.0, motor_force=600.0)
    batteries = [Battery(200_000, "joules"), Battery(2_000)]
    distances, units = np.array([10.0]), np.array([20_000.0])
    for motion, lasts in (("grid", True), (RigidBodyMotion(), True), (DrivingMotion(heavy), False)):
        env = FleetEnv(HALL, 1, battery=batteries[0], backend=motion)
        assert Chargers(env, TravelTimes(HALL)).lasts(units, distances).tolist() == [lasts]
    env = FleetEnv(HALL, 1, battery=batteries[1], backend=DrivingMotion(heavy, period=0.25))
    assert use_and_charge(env) == pytest.approx((4, 4 * batteries[1].step_charge(1.0)))


def test_two_robots_at_one_charger_take_turns_and_keep_the_exit_free() -> None:
    one = Layout(["C" + "." * 28 + "."])
    chargers = chargers_of(2, one)
    chargers.update(needs([0, 4], [30, 48]))
    assert chargers.turn.tolist() == [0, NONE]  # the other robot would wait there for a long time
    chargers.update(needs([0, 20], [140, 60]))
    assert chargers.turn.tolist() == [0, 0]
    for cell in (10, QUEUE_DISTANCE + 1):
        assert chargers.goals(np.array([0, cell])).tolist() == [0, 0]
    waiting = np.array([0, QUEUE_DISTANCE])
    assert chargers.goals(waiting).tolist() == [0, QUEUE_DISTANCE]
    assert chargers.charging(waiting).tolist() == [True, False]
    chargers.update(needs([0, QUEUE_DISTANCE], [195, 60]))
    assert chargers.turn.tolist() == [NONE, 0]
    assert chargers.goals(waiting).tolist() == [NONE, QUEUE_DISTANCE]  # it has not left yet
    assert chargers.goals(np.array([12, QUEUE_DISTANCE])).tolist() == [NONE, 0]


def test_the_more_robots_wait_for_a_charger_the_earlier_they_begin() -> None:
    def first_to_go(robots: int) -> int:
        chargers, cells = chargers_of(robots), list(range(5, 5 + robots))
        for battery in range(190, 0, -1):
            chargers.update(needs(cells, [battery] * robots))
            if (chargers.turn != NONE).any():
                return battery
        return 0

    assert first_to_go(1) < first_to_go(6) < first_to_go(12)


def test_no_robot_goes_to_a_charger_with_a_dead_robot() -> None:
    chargers = chargers_of(2)
    chargers.update(needs([5, 3], [29, 150]))
    assert chargers.turn.tolist() == [0, NONE]
    chargers.update(needs([5, 0], [28, 0]))
    assert chargers.turn.tolist() == [1, NONE]


def test_a_charger_that_nobody_uses_is_for_robots_below_their_limits() -> None:
    chargers = chargers_of(3)
    limits = np.array([100.0, 100.0, 100.0])
    chargers.update(needs([1, 2, 27], [90, 95, 120], limits=limits))
    assert chargers.turn.tolist() == [0, NONE, NONE]  # there is one at 0, and 29 is far away


def test_no_idle_robot_goes_to_a_charger_where_its_turn_would_end_at_once() -> None:
    limits = np.array([180.0])
    for knee, below in ((1.0, 180), (0.8, 144), (0.4, 126)):
        chargers = chargers_of(1, battery=Battery(200, knee=knee))
        chargers.update(needs([8], [below], limits=limits))
        assert chargers.turn.tolist() == [NONE]
        chargers.update(needs([8], [below - 1], limits=limits))
        assert chargers.turn.tolist() == [0]
        assert below < chargers._full


def test_a_robot_in_need_goes_to_any_charger_that_it_can_reach() -> None:
    split = Layout(["C...#...C"])
    chargers = chargers_of(3, split)
    for _ in range(3):
        chargers.update(needs([1, 2, 3], [9, 8, 7]))
    assert sorted(chargers.turn.tolist()) == [NONE, 0, 0]
    for charge, turn in (2, NONE), (3, 0), (2, NONE):  # with a flat battery it would block it
        chargers.update(needs([2, 6, 7], [charge, 99, 99]))
        assert chargers.turn[0] == turn


def test_paths_avoid_chargers_where_possible() -> None:
    layout = Layout([".C.", "...", "#.#"])
    graph = Graph(layout, costs_around_chargers(layout))
    assert graph.distances(2)[0] == 4
    assert graph.distances(1)[0] == 1 + INTO_CHARGER
    assert graph.distances(0)[1] == 1  # leaving it has no extra cost
    doubled = costs_around_chargers(layout, np.full((9, 4), 2, np.float32))
    assert doubled is not None
    assert Graph(layout, doubled).distances(2)[0] == 8


def test_only_a_robot_near_its_charger_keeps_its_turn() -> None:
    chargers = chargers_of(2, Layout(["C" + "." * 29]))
    chargers.update(needs([20, 2], [45, 100]))
    assert chargers.turn.tolist() == [0, NONE]
    chargers.update(needs([19, 2], [44, 20]))
    assert chargers.turn.tolist() == [NONE, 0]
    cells = np.array([QUEUE_DISTANCE, 2])
    chargers.update(needs(cells.tolist(), [10, 20]))
    assert chargers.goals(cells).tolist() == [QUEUE_DISTANCE, 0]
    cells = np.array([1, 2])  # whoever is nearer comes first
    chargers.update(needs(cells.tolist(), [8, 18]))
    assert chargers.goals(cells).tolist() == [0, 2]
    assert chargers.charging(cells).tolist() == [False, False]
    for battery, turn in (95, 0), (105, NONE):
        chargers.update(needs([0, QUEUE_DISTANCE], [battery, 2 * QUEUE_DISTANCE + 4]))
        assert chargers.charging(np.array([0, QUEUE_DISTANCE])).tolist() == [turn == 0, False]
        assert chargers.turn.tolist() == [turn, 0]


def test_the_next_robot_gives_its_turn_to_a_robot_in_need() -> None:
    one = Layout(["C" + "." * 29])
    chargers = chargers_of(3, one)
    chargers.turn[:2] = 0
    chargers.update(needs([0, 3, 6], [150, 130, 100]))
    assert chargers.turn.tolist() == [0, 0, NONE]
    chargers.update(needs([0, 3, 6], [160, 129, 25]))
    assert chargers.turn.tolist() == [0, NONE, 0]


def test_a_robot_gives_its_turn_back_where_a_failed_robot_cuts_the_charger_off() -> None:
    times = TravelTimes(HALL)
    chargers = Chargers(FleetEnv(HALL, 2, battery=200), times)
    chargers.update(needs([5, 3], [29, 150]))
    assert chargers.turn.tolist() == [0, NONE]
    times.close(frozenset([3]))
    chargers.measure()
    chargers.update(needs([5, 3], [28, 0]))
    assert chargers.turn.tolist() == [1, NONE]
