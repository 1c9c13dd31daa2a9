"""Runs of a fleet in all worlds: orders in seconds, and hits."""

from contextlib import closing
from dataclasses import replace
from math import inf

import pytest

from agents.lab.commands.compare_fleets import (
    BATTERY,
    DISTURBED,
    DRIVING,
    PLAN,
    STOPPING,
    WORLDS,
    Setting,
    TimedOrder,
    count_hits,
    draw_orders,
    in_steps,
    make_env,
    make_world,
    run_trial,
    score_of,
)
from warehouse_core import FleetEpisode, Layout, shelf_layout
from warehouse_core.motion.base import Contact

STOP = 30.0
LINE = Layout(["P....D"])
LAYOUT = shelf_layout(1, 2, aisle=2, pickups=2, dropoffs=2, chargers=1, seed=1)
SETTING = Setting(LAYOUT, 3, "pibt", 0.2, 5, 0.05, STOP)


@pytest.fixture(scope="module")
def records() -> dict[str, FleetEpisode]:
    found = {}
    for world in WORLDS:
        _, record = run_trial(world, 3, setting=SETTING, kept=3)
        assert record is not None
        found[world] = record
    return found


def test_random_orders_have_the_given_rate_and_lead_from_pickups_to_dropoffs() -> None:
    setting = replace(SETTING, rate=0.5, count=2000)
    orders = draw_orders(setting, seed=1)
    assert orders[-1].released == pytest.approx(4000, rel=0.1)
    assert {order.pickup for order in orders} == set(LAYOUT.pickups)
    assert {order.dropoff for order in orders} == set(LAYOUT.dropoffs)
    assert all(100 <= order.due - order.released <= 300 for order in orders)
    assert orders == draw_orders(setting, seed=1) != draw_orders(setting, seed=2)


def test_orders_in_steps_are_never_released_too_early_nor_due_too_late() -> None:
    orders = [TimedOrder(0.0, 10.0, (0, 0), (0, 1)), TimedOrder(4.9, 5.1, (0, 0), (0, 1))]
    found = [(order.released, order.due) for order in in_steps(orders, 2.4)]
    assert found == [(0, 4), (3, 3)]


def test_a_step_lasts_for_a_cell_or_a_quarter_of_it_or_until_a_loaded_robot_is_at_rest() -> None:
    seconds = [make_world(world, SETTING, 60.0, 1).step_seconds for world in WORLDS]
    assert seconds == pytest.approx([1.0, 2.37, 0.25, 0.25], abs=0.05)


@pytest.mark.parametrize("world", WORLDS)
def test_chargers_supply_the_same_power_in_all_worlds(world: str) -> None:
    made = make_world(world, SETTING, 60.0, 1)
    with closing(make_env(SETTING, made, draw_orders(SETTING, 3))) as env:
        supplied = env.settings.battery.step_charge(env.cell_size) / made.step_seconds
    assert supplied == pytest.approx(BATTERY.step_charge(1.0), rel=0.01)


def test_worlds_have_the_same_starts_and_orders(records: dict[str, FleetEpisode]) -> None:
    plan = records[PLAN]
    for world, record in records.items():
        assert (record.cells[0] == plan.cells[0]).all()
        places = [(order.pickup, order.dropoff) for order in record.orders]
        assert places == [(order.pickup, order.dropoff) for order in plan.orders]
        seconds = make_world(world, SETTING, 60.0, 3).step_seconds
        for done, order in zip(record.orders, draw_orders(SETTING, 3), strict=True):
            assert 0 <= done.released * seconds - order.released < seconds


def test_deliveries_are_on_time_by_the_clock_in_seconds(records: dict[str, FleetEpisode]) -> None:
    record, orders = records[STOPPING], draw_orders(SETTING, 3)
    clock = record.seconds.max(axis=1).cumsum()
    ends = [clock[(order.delivered or 0) - 1] for order in record.orders]
    for number, end in enumerate(ends):
        for due, share in ((end, 1.0), (end - 0.01, 0.8)):
            changed = [order._replace(due=1e9) for order in orders]
            changed[number] = orders[number]._replace(due=due)
            assert score_of(record, changed, 0).on_time == pytest.approx(share)
    assert score_of(record, orders, 0).makespan == max(ends)


def test_orders_that_are_not_delivered_are_late(records: dict[str, FleetEpisode]) -> None:
    record = records[PLAN]
    orders = [order._replace(due=1e9) for order in draw_orders(SETTING, 3)]
    gone = [record.orders[0]._replace(delivered=None), *record.orders[1:]]
    measures = replace(record.measures, stranded=1)
    score = score_of(_with(record, orders=gone, measures=measures), orders, late_plans=2)
    assert (score.on_time, score.delivered, score.lost, score.late_plans) == (0.8, 4, 1, 2)


def test_a_robot_that_fails_is_lost_once() -> None:
    score, _ = run_trial(DISTURBED, 3, setting=replace(SETTING, noise=0.0, stop=inf))
    assert score.lost == 1


def test_two_robots_that_touch_have_one_hit(records: dict[str, FleetEpisode]) -> None:
    record = records[DRIVING]
    assert count_hits(record.motions) == 0
    first, second, third = record.motions[0]
    touch = [Contact(0.5, 1.0, (1.0, 1.0), name) for name in ("robot 1", "robot 0", "wall")]
    motions = [
        (
            first._replace(contacts=(touch[0],)),
            second._replace(contacts=(touch[1],)),
            third._replace(contacts=(touch[2],)),
        ),
        *record.motions[1:],
    ]
    assert count_hits(motions) == 2


def test_the_same_seed_gives_the_same_score(records: dict[str, FleetEpisode]) -> None:
    score, record = run_trial(DISTURBED, 3, setting=SETTING)
    assert score == score_of(records[DISTURBED], draw_orders(SETTING, 3), 0)
    assert record is None


def _with(record: FleetEpisode, **changed: object) -> FleetEpisode:
    values = {name: getattr(record, name) for name in FleetEpisode.__slots__}
    return FleetEpisode(**(values | changed))
