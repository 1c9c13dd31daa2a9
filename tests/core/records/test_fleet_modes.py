"""Each failure mode of a fleet, in an episode that shows it."""

from collections.abc import Iterable, Sequence
from typing import Any

import pytest

from warehouse_core import FleetEnv, Order
from warehouse_core.fleet import Battery
from warehouse_core.records import FleetEpisode, FleetRecorder, diagnose_fleet

HALL = ["#######", "#P...D#", "#.....#", "#######"]
CORRIDOR = ["#######", "#P...D#", "#######"]
ROUND = ["PICK", "E", "DROP", "W"]
"""Deliveries between a pickup and the dropoff on its right."""


def driven(
    rows: Sequence[str], starts: Sequence[Any], steps: Iterable[Sequence[str]], **settings: Any
) -> FleetEpisode:
    """Return the record of robots that carry out these actions until they or the episode end."""
    env = FleetEnv(rows, len(starts), starts=starts, dispatch=False, **settings)
    recorder = FleetRecorder(env, seed=0)
    for actions in steps:
        if not recorder.ended:
            recorder.step(actions)
    return recorder.episode


def mode_of(episode: FleetEpisode) -> tuple[str, tuple[int, ...]]:
    found = diagnose_fleet(episode)
    return found.mode, found.robots


def test_an_order_that_no_way_leads_to_is_named_with_its_robot() -> None:
    rows = ["P#P.D"]
    orders = [Order(0, 9, (0, 2), (0, 4)), Order(0, 9, (0, 0), (0, 4), robot=1)]
    episode = driven(rows, [(0, 2), (0, 3)], [["PICK", "WAIT"]], orders=orders)
    assert mode_of(episode) == ("unreachable", (1,))
    expected = "no way leads from robot 1 at (0, 3) to the pickup of order 1 at (0, 0)"
    assert diagnose_fleet(episode).sentence == expected
    open_order = [Order(0, 9, (0, 0), (0, 4))]
    episode = driven(rows, [(0, 2), (0, 3)], [["WAIT", "WAIT"]], orders=open_order)
    assert mode_of(episode) == ("unreachable", (0, 1))
    assert "from any robot to the pickup" in diagnose_fleet(episode).sentence


def test_an_item_that_cannot_be_delivered_is_unreachable_for_its_taker() -> None:
    orders = [Order(0, 9, (0, 0), (0, 3))]
    episode = driven(["P.#D"], [(0, 0), (0, 1)], [["PICK", "WAIT"]], orders=orders)
    assert mode_of(episode) == ("unreachable", (0,))
    assert "to the dropoff of order 0 at (0, 3)" in diagnose_fleet(episode).sentence


def test_robots_without_battery_are_stranded_with_the_moves_that_they_stop() -> None:
    steps = [["E", "WAIT"], ["E", "WAIT"], ["WAIT", "W"]]
    episode = driven(CORRIDOR, [(1, 2), (1, 3)], steps, battery=Battery(104, "joules"))
    assert mode_of(episode) == ("stranded", (0,))
    expected = "the battery of robot 0 at (1, 2) ran out and stopped 1 move of others"
    assert diagnose_fleet(episode).sentence == expected


def test_robots_that_stop_each_other_are_a_ring_and_others_queue_behind_it() -> None:
    # The moves of robots 0 and 2 have the same target; robot 3 follows robot 2.
    steps = [["W", "E", "E", "E"]] * 12
    episode = driven(CORRIDOR, [(1, 5), (1, 4), (1, 3), (1, 2)], steps)
    assert mode_of(episode) == ("deadlock", (0, 2))
    assert diagnose_fleet(episode).sentence == (
        "robot 0 at (1, 5) and robot 2 at (1, 3) stop each other, for the last 12 steps; behind "
        "them robot 1 at (1, 4) and robot 3 at (1, 2)"
    )


def test_robots_behind_one_that_waits_are_a_queue() -> None:
    steps = [["WAIT", "W", "W"]] * 12
    episode = driven(CORRIDOR, [(1, 2), (1, 3), (1, 5)], steps)
    assert mode_of(episode) == ("deadlock", (2, 1, 0))
    assert diagnose_fleet(episode).sentence == (
        "robot 2 at (1, 4) and robot 1 at (1, 3) are stopped by robot 0 at (1, 2), which stays, "
        "for the last 11 steps"
    )


def test_short_stops_are_no_deadlock() -> None:
    assert mode_of(driven(CORRIDOR, [(1, 2), (1, 3)], [["WAIT", "W"]] * 9))[0] != "deadlock"


def test_an_order_that_ten_later_ones_overtake_starves() -> None:
    rows = ["P..", "PD."]
    early = Order(0, 99, (0, 0), (1, 1))
    later = [Order(1, 99, (1, 0), (1, 1), robot=0) for _ in range(10)]
    steps = [["WAIT", "WAIT"]] + [[action, "WAIT"] for action in ROUND * 10]
    episode = driven(rows, [(1, 0), (0, 2)], steps, orders=[early, *later])
    assert mode_of(episode) == ("starvation", ())
    assert "order 0 at (0, 0) waited for 41 steps, while 10" in diagnose_fleet(episode).sentence
    episode = driven(rows, [(1, 0), (0, 2)], steps, orders=[early, *later[:9]])
    assert mode_of(episode)[0] != "starvation"


def test_moves_stopped_by_robots_are_congestion() -> None:
    steps = [["E", "W"], ["W", "E"], ["E", "W"]] * 5
    episode = driven(HALL, [(2, 2), (2, 3)], steps)
    assert mode_of(episode) == ("congested", (0, 1))
    assert diagnose_fleet(episode).sentence == (
        "10 of 30 moves were stopped by robots or people, 0 of them by people; most, 5, from (2, 2)"
    )


@pytest.mark.parametrize(("waits", "mode"), [(6, "idle"), (4, "served")])
def test_a_fleet_that_waits_half_of_the_time_is_idle(waits: int, mode: str) -> None:
    steps = [["WAIT", "WAIT"]] * waits + [["E", "E"], ["W", "W"]] * (5 - waits // 2)
    episode = driven(HALL, [(1, 2), (2, 2)], steps)
    assert mode_of(episode) == (mode, (0, 1))


@pytest.mark.parametrize(("due", "mode"), [(2, "late"), (3, "served")])
def test_deliveries_after_their_due_time_are_late(due: int, mode: str) -> None:
    orders = [Order(0, due, (0, 0), (0, 1))]
    episode = driven(["PD"], [(0, 0)], [[action] for action in ROUND], orders=orders)
    assert mode_of(episode) == (mode, (0,))
    expected = {
        "late": "1 of 1 deliveries were late; the mean over all is 1 steps",
        "served": "1 of 1 order delivered in 3 steps",
    }
    assert diagnose_fleet(episode).sentence == expected[mode]
