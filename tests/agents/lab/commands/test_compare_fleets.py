"""Fleets in four worlds: ``warehouse compare backends --robots N``."""

import csv
from contextlib import closing
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.player import page_in, said_by

from agents.lab.commands.compare_fleets import (
    BATTERY,
    DISTURBED,
    DRIVING,
    PLAN,
    STOPPING,
    WORLDS,
    Score,
    Setting,
    TimedOrder,
    count_hits,
    draw_orders,
    in_steps,
    losses,
    make_env,
    make_world,
    parse_disturbed,
    run_trial,
    score_of,
    table_of,
)
from warehouse_core import FleetEpisode, shelf_layout
from warehouse_core.motion.base import Contact

SMALL = (
    "compare", "backends", "--robots", 2, "--count", 1, "--order-rate", 0.1, "--seed", 5,
    "--jobs", 1, "--disturbed", "0.05:5", "--layout", "shelves",
)  # fmt: skip
PLAIN = Score(100.0, 1.0, 2000.0, 0, 144.0, 4, 0, 0)


def scores(*shares: float) -> dict[str, list[Score]]:
    """Return scores of two seeds with shares of the plan's deliveries; one is half as fast."""
    return {
        world: [PLAIN._replace(per_hour=rate * share) for rate in (100.0, 50.0)]
        for world, share in zip(WORLDS, shares, strict=True)
    }


def test_worlds_are_compared_in_tables_a_page_and_a_file_of_values(warehouse: Warehouse) -> None:
    code, out, _ = warehouse(*SMALL, "-n", 1, "--save", "a.html", "--save", "a.csv")
    assert code == 0
    lines = Path("a.csv").read_text(encoding="utf-8").splitlines()
    rows = {row["world"]: row for row in csv.DictReader(lines)}
    assert list(rows) == [*WORLDS]
    for row in rows.values():
        assert (row["seed"], row["delivered"], row["lost"]) == ("5", "1", "0")
        assert float(row["per_hour"]) == pytest.approx(3600 / float(row["makespan"]))
    makespans = {world: float(row["makespan"]) for world, row in rows.items()}
    assert makespans[PLAN] < makespans[DRIVING] < makespans[STOPPING]
    assert all(f" {makespan:.3g} " in out for makespan in makespans.values())
    page = Path("a.html").read_text(encoding="utf-8")
    assert [track["title"] for track in said_by(page_in(page))["tracks"]] == [*WORLDS]
    assert page.count("<table") == 1
    assert page.count("<iframe") == 1
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_a_plan_that_delivers_nothing_has_no_shares() -> None:
    nothing = {world: [PLAIN._replace(per_hour=0.0)] for world in WORLDS}
    assert [cells[2] for cells in table_of(nothing, "").rows] == ["none"] * 4
    half = {world: [*runs, PLAIN] for world, runs in nothing.items()}
    assert [cells[2] for cells in table_of(half, "").rows] == ["100"] * 4


def test_losses_are_reported() -> None:
    found = scores(1.0, 1.0, 1.0, 1.0)
    assert losses(found, 4) == []
    found[DISTURBED][1] = PLAIN._replace(delivered=3, lost=1)
    assert losses(found, 4) == ["disturbed, in 2 episodes: 1 order not delivered and 1 robot lost"]


@pytest.mark.parametrize("text", ["0.6:9", "5", "0.1:x", "0.1:-1"])
def test_disturbances_of_another_form_are_refused(text: str, refused: Refused) -> None:
    said = refused("compare", "backends", "-r", 2, "--disturbed", text, code=2)
    assert said == (
        f"--disturbed is {text!r}; it must be a share 0..0.5 and seconds, such as 0.05:60"
    )


def test_a_robot_that_fails_stops_forever() -> None:
    assert parse_disturbed("0:inf") == (0.0, inf)


# Worlds.

STOP = 30.0
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


def _with(record: FleetEpisode, **changed: object) -> FleetEpisode:
    values = {name: getattr(record, name) for name in FleetEpisode.__slots__}
    return FleetEpisode(**(values | changed))
