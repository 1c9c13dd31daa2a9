"""Runs of ``warehouse gap``: orders in seconds, hits, and what time is spent on."""

from contextlib import closing
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from agents.lab.commands.gap.orders import TimedOrder, draw_orders, in_steps
from agents.lab.commands.gap.spent_time import time_spent
from agents.lab.commands.gap.trial import Setting, count_hits, make_env, run_trial, score_of
from agents.lab.commands.gap.worlds import (
    ALONE,
    DISTURBED,
    DRIVING,
    PLAN,
    STOPPING,
    WORLDS,
    Shocks,
    make_world,
)
from agents.mapf.execution import corner_steps
from warehouse_core import FleetEpisode, Layout, shelf_layout
from warehouse_core.fleet import Battery
from warehouse_core.motion.base import Contact
from warehouse_physics import RobotSpec

STOP = 30.0
LINE = Layout(["P....D"])
LAYOUT = shelf_layout(1, 2, aisle=2, pickups=2, dropoffs=2, chargers=1, seed=1)
SETTING = Setting(
    LAYOUT, 3, "pibt", None, 10.0, Battery(30_000, "joules"), 0.2, 5, (20, 60), Shocks(0.05, STOP)
)


@pytest.fixture(scope="module")
def records() -> dict[str, FleetEpisode]:
    found = {}
    for world in WORLDS:
        record = run_trial(world, 3, setting=SETTING, kept=3).record
        assert record is not None
        found[world] = record
    return found


def test_orders_are_drawn_at_the_rate_between_stations() -> None:
    orders = draw_orders(LAYOUT, 0.5, 2000, (10, 30), seed=1)
    assert orders[-1].released == pytest.approx(4000, rel=0.1)
    assert {order.pickup for order in orders} == set(LAYOUT.pickups)
    assert {order.dropoff for order in orders} == set(LAYOUT.dropoffs)
    assert all(10 <= order.due - order.released <= 30 for order in orders)
    assert orders == draw_orders(LAYOUT, 0.5, 2000, (10, 30), seed=1)
    assert orders != draw_orders(LAYOUT, 0.5, 2000, (10, 30), seed=2)


def test_times_in_steps_are_never_too_early_nor_due_too_late() -> None:
    orders = [TimedOrder(0.0, 10.0, (0, 0), (0, 1)), TimedOrder(4.9, 5.1, (0, 0), (0, 1))]
    found = [(order.released, order.due) for order in in_steps(orders, 2.4)]
    assert found == [(0, 4), (3, 3)]


def test_a_step_lasts_for_a_cell_or_a_quarter_of_it_or_until_a_loaded_robot_is_at_rest() -> None:
    seconds = [make_world(world, SETTING.shocks, 3, 60.0, 1).step_seconds for world in WORLDS]
    assert seconds == pytest.approx([1.0, 2.37, 0.25, 0.25, 0.25], abs=0.05)


@pytest.mark.parametrize("world", WORLDS)
def test_chargers_supply_as_much_in_a_second_in_all_worlds(world: str) -> None:
    made, orders = make_world(world, SETTING.shocks, 3, 60.0, 1), SETTING.orders(3)
    with closing(make_env(replace(SETTING, battery=Battery(9_000, "joules")), made, orders)) as env:
        supplied = env.settings.battery.step_charge(env.cell_size) / made.step_seconds
    assert supplied == pytest.approx(Battery(9_000, "joules").step_charge(1.0), rel=0.01)


def test_worlds_have_the_same_starts_and_orders(records: dict[str, FleetEpisode]) -> None:
    plan = records[PLAN]
    for world, record in records.items():
        assert (record.cells[0] == plan.cells[0]).all()
        places = [(order.pickup, order.dropoff) for order in record.orders]
        assert places == [(order.pickup, order.dropoff) for order in plan.orders]
        seconds = make_world(world, SETTING.shocks, 3, 60.0, 3).step_seconds
        for done, order in zip(record.orders, SETTING.orders(3), strict=True):
            assert 0 <= done.released * seconds - order.released < seconds


@pytest.mark.parametrize("world", WORLDS)
def test_the_time_of_all_robots_is_spent_on_something(
    records: dict[str, FleetEpisode], world: str
) -> None:
    record = records[world]
    spent = time_spent(record, 1.0)
    assert spent.sum() == pytest.approx(3 * record.measures.seconds)
    assert (spent[[0, 2, 3, 4]] >= 0).all()
    rest = max(1 - make_world(world, SETTING.shocks, 3, 60.0, 3).step_seconds, 0.0)
    assert spent[3] >= (2 * 5 - rest) * 0.99, "five items are picked and dropped, the last partly"
    moves = np.count_nonzero(np.diff(record.cells, axis=0))
    assert spent[0] == pytest.approx(moves, rel=0.1), "a cell takes a second at top speed"


def test_bodies_that_stop_in_every_cell_lose_most_by_it(records: dict[str, FleetEpisode]) -> None:
    excess = {world: time_spent(record, 1.0)[1] for world, record in records.items()}
    moves = np.count_nonzero(np.diff(records[STOPPING].cells, axis=0))
    assert excess[PLAN] == 0
    assert excess[STOPPING] == pytest.approx(1.2 * moves, rel=0.2)
    assert 0 < excess[DRIVING] < excess[STOPPING] / 2


def test_a_robot_that_stops_waits() -> None:
    setting = replace(SETTING, layout=LINE, robots=1, rate=1.0, count=1, shocks=Shocks(0.0, STOP))
    waits = {}
    for world in (DRIVING, DISTURBED):
        score = run_trial(world, 1, setting=setting).score
        waits[world] = score.spent[2]
    assert waits[DRIVING] + STOP - 2 < waits[DISTURBED] < waits[DRIVING] + STOP + 2


def test_a_robot_without_others_is_as_fast_as_alone() -> None:
    setting = replace(SETTING, planner=f"windowed:turn_cost={corner_steps(RobotSpec())}", robots=1)
    alone, driving = (run_trial(world, 3, setting=setting).score for world in (ALONE, DRIVING))
    assert alone.makespan == pytest.approx(driving.makespan, abs=0.5)  # ways of equal cost differ


def test_robots_that_are_each_alone_pass_each_other_in_a_corridor() -> None:
    setting = replace(SETTING, layout=LINE, robots=2, rate=1.0, count=4)
    record = run_trial(ALONE, 1, setting=setting, kept=1).record
    assert record is not None
    assert all(order.delivered for order in record.orders)
    assert (record.cells[:, 0] == record.cells[:, 1]).any(), "one goes through the other"
    assert count_hits(record.motions) == 0
    assert time_spent(record, 1.0)[2] < 1


def test_who_waits_has_an_order() -> None:
    setting = replace(SETTING, layout=LINE, robots=1, rate=0.02, count=2)
    record = run_trial(PLAN, 1, setting=setting, kept=1).record
    assert record is not None
    _, _, waiting, handling, idle = time_spent(record, 1.0)
    assert (waiting, handling) == (0, 4)
    assert idle > setting.orders(1)[0].released / 2


def test_deliveries_are_on_time_by_the_clock_in_seconds(records: dict[str, FleetEpisode]) -> None:
    record, orders = records[STOPPING], SETTING.orders(3)
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
    orders = [order._replace(due=1e9) for order in SETTING.orders(3)]
    gone = [record.orders[0]._replace(delivered=None), *record.orders[1:]]
    measures = replace(record.measures, stranded=1)
    score = score_of(_with(record, orders=gone, measures=measures), orders, late_plans=2)
    assert (score.on_time, score.delivered, score.lost, score.late_plans) == (0.8, 4, 1, 2)


def test_a_robot_that_dies_is_lost_once() -> None:
    setting = replace(SETTING, shocks=Shocks(0.0, inf))
    assert run_trial(DISTURBED, 3, setting=setting).score.lost == 1


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
    again = run_trial(DISTURBED, 3, setting=SETTING)
    assert again.score == score_of(records[DISTURBED], SETTING.orders(3), 0)
    assert again.record is None


def _with(record: FleetEpisode, **changed: object) -> FleetEpisode:
    values = {name: getattr(record, name) for name in FleetEpisode.__slots__}
    return FleetEpisode(**(values | changed))
