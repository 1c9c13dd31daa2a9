"""Which robots are led to their goals at a time."""

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.mapf import leading as module
from agents.mapf.graph import Graph
from agents.mapf.kernels.floor import FAR
from agents.mapf.leading import Leading, regions_of
from agents.mapf.planner import NO_CELLS, Situation
from warehouse_core import Layout

HALL = Graph(Layout(["." * 12] * 3))
"""A floor of two regions, the first of 24 cells and the second of 12."""


def test_few_robots_are_led_into_the_same_region(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "REGION_LED", 1 / 24)
    regions, room = regions_of(HALL)
    assert regions[[0, 7, 8, 24]].tolist() == [0, 0, 1, 0]
    assert room.tolist() == [1, 1]
    cells, goals = [0, 12, 35, 20], [3, 14, 33, 8]
    leading = Leading(HALL, 4, most=3, seed=0)
    given = situation(cells, goals)
    # Robots 1 and 2 are nearest; robot 0 has no room, and robot 3 goes where robot 2 does.
    assert leading.goals(given, np.array([3, 2, 2, 4])).tolist() == [0, 14, 33, 20]
    urgent = given._replace(urgent=np.array([0]))
    assert leading.goals(urgent, np.array([3, 2, 2, 4])).tolist() == [3, 14, 33, 20]


def test_a_robot_that_comes_no_nearer_rests_and_is_led_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "STALL", 3)
    monkeypatch.setattr(module, "REST", 4)
    leading, led = Leading(HALL, 2, most=1, seed=0), []
    for step in range(16):
        goals = leading.goals(situation([0, 35], [3, 30]), np.array([3, 20 - step]))
        assert (goals == [3, 35]).all() or (goals == [0, 30]).all()
        led.append(int(goals[0] != 0))
    stalls = led.index(0)
    assert stalls == 3
    assert led[stalls:] == [0] * (16 - stalls)  # the other one comes nearer, and is led until then
    leading, led = Leading(HALL, 1, most=1, seed=0), []
    for _ in range(12):
        led.append(int(leading.goals(situation([0], [3]), np.array([3]))[0] != 0))
    rest = led[3:].index(1)
    assert 2 <= rest < 6
    assert led[3 + rest :][:3] == [1, 1, 1]
    assert leading.goals(situation([0], [5]), np.array([5])).tolist() == [5]


def test_urgent_robots_do_not_rest_and_those_without_a_way_are_not_led() -> None:
    for urgent, least, most in (([0], 150, 150), ([], 60, 120)):
        leading = Leading(HALL, 1, most=1, seed=0)
        given = situation([0], [3])._replace(urgent=np.array(urgent, np.intp))
        led = [leading.goals(given, np.array([3]))[0] == 3 for _ in range(150)]
        assert least <= sum(led) <= most
    leading = Leading(HALL, 2, most=1, seed=0)
    given = situation([0, 35], [3, 30])
    assert leading.goals(given, np.array([FAR, 9])).tolist() == [0, 30]
    assert leading.goals(given, np.array([3, FAR])).tolist() == [3, 35]


def test_robots_that_rest_keep_their_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "REGION_LED", 1 / 24)
    monkeypatch.setattr(module, "STALL", 2)
    leading, given = Leading(HALL, 2, most=2, seed=0), situation([0, 12], [3, 18])
    led = [(leading.goals(given, np.array([3, 6])) != given.cells).tolist() for _ in range(20)]
    assert led == [[True, False]] * 2 + [[False, False]] * 18


def test_new_goals_in_the_same_array_are_seen() -> None:
    leading, goals = Leading(HALL, 1, most=1, seed=0), np.array([3])
    given = Situation(np.array([0]), goals, np.array([False]), NO_CELLS)
    for _ in range(module.STALL):
        leading.goals(given, np.array([3]))
    goals[0] = 5
    assert leading.goals(given, np.array([5])).tolist() == [5]


def test_rests_differ_so_that_robots_that_block_one_another_come_free() -> None:
    leading = Leading(HALL, 8, most=8, seed=1)
    given, distances = situation(range(8), range(8, 16)), np.full(8, 5)
    led = [leading.goals(given, distances) != given.cells for _ in range(120)]
    counts = np.sum(led, axis=1)
    assert counts[: module.STALL].tolist() == [8] * module.STALL
    assert counts[module.STALL] == 0
    assert len({*counts[module.STALL :].tolist()}) > 3
