"""Measures of an episode, computed by hand."""

import math
from typing import Any

import pytest
from helpers.fleet_truth import DROP, EAST, NORTH, PICK, SOUTH, WAIT, WEST

from warehouse_core import FleetEnv, Layout, Order
from warehouse_core.motion.grid import nominal_joules

FLOOR = Layout(["...C", ".#.."])
IDLE, MOVE = (nominal_joules(1.0, moving=moving) for moving in (False, True))


def test_an_episode_of_three_robots() -> None:
    orders = [
        Order(0, 4, (0, 0), (0, 1), robot=0),
        Order(0, 3, (0, 2), (1, 2), robot=1),
        Order(1, 99, (1, 0), (0, 0), robot=2),
    ]
    fleet = FleetEnv(FLOOR, 3, orders=orders, starts=[(0, 0), (0, 2), (0, 3)], battery=10)
    fleet.reset()
    for actions in (
        [PICK, PICK, WAIT],  # robot 2 charges
        [EAST, SOUTH, WAIT],
        [WAIT, WEST, WEST],  # robot 1 at a wall
        [EAST, NORTH, WEST],  # robot 0 and 2 head-on, robot 1 behind
        [DROP, DROP, DROP],  # just on time, two steps late, and never delivered
    ):
        fleet.step(actions)
    measures = fleet.measures
    assert (measures.steps, measures.seconds) == (5, 5.0)
    assert (measures.orders, measures.delivered, measures.stranded) == (3, 2, 0)
    assert measures.per_hour == 2 / 5 * 3600
    assert (measures.mean_lateness, measures.worst_lateness, measures.on_time) == (1.5, 2.0, 0.0)
    assert (measures.distance, measures.waits, measures.charging) == (3, 1, 2)
    assert (measures.blocked_by_wall, measures.blocked_by_robot) == (1, 3)
    assert measures.blocked_by_person == 0
    assert measures.joules == pytest.approx(7 * MOVE + 8 * IDLE)
    assert measures.joules_per_delivery == measures.joules / 2
    counts = fleet._engine.tally.counts(0)
    assert counts.sum(axis=0).tolist() == [5, 5, 5]
    assert counts.tolist()[:3] == [[1, 1, 1], [1, 0, 0], [0, 0, 2]]


def test_deliveries_on_time_are_late_by_nothing() -> None:
    orders = [Order(0, due, (0, 0), (0, 1), robot=0) for due in (3, 9)]
    fleet = FleetEnv(FLOOR, 2, orders=orders, starts=[(0, 0), (0, 2)])
    fleet.reset()
    for action in (PICK, EAST, DROP, WEST, PICK, EAST, DROP):
        fleet.step([action, WAIT])
    measures = fleet.measures
    assert (measures.mean_lateness, measures.worst_lateness, measures.on_time) == (0.0, 0.0, 1.0)


def test_what_nothing_was_measured_for_is_not_a_number() -> None:
    fleet = FleetEnv(FLOOR, 1)
    fleet.reset()
    names: Any = ("per_hour", "mean_lateness", "worst_lateness", "on_time", "joules_per_delivery")
    assert all(math.isnan(getattr(fleet.measures, name)) for name in names)
    assert (fleet.measures.steps, fleet.measures.orders, fleet.measures.delivered) == (0, 0, 0)


def test_robots_that_have_ended_count_for_nothing_and_a_reset_clears_all() -> None:
    fleet = FleetEnv(["PD.", "..."], 2, starts=[(0, 0), (1, 0)])
    fleet.reset()
    for actions in ([PICK, WAIT], [EAST, WAIT], [DROP, WAIT], [EAST, EAST], {1: EAST}):
        fleet.step(actions)
    measures = fleet.measures
    assert (measures.delivered, measures.distance, measures.waits) == (1, 3, 3)
    first = fleet.measures
    fleet.reset()
    assert fleet.measures != first
    assert (fleet.measures.steps, fleet.measures.seconds, fleet.measures.joules) == (0, 0.0, 0.0)
    assert fleet._engine.tally.counts(0).sum() == 0
