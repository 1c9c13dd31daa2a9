"""Each failure mode of a fleet, in an episode that shows it."""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pytest

from warehouse_core import FleetEnv, Order, OrderQueue
from warehouse_core.fleet import Battery, People
from warehouse_core.records import FleetEpisode, FleetRecorder, diagnose

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
    found = diagnose(episode)
    return found.mode, found.robots


def test_an_order_that_no_way_leads_to_is_named_with_its_robot() -> None:
    rows = ["P#P.D"]
    orders = [Order(0, 9, (0, 2), (0, 4)), Order(0, 9, (0, 0), (0, 4), robot=1)]
    episode = driven(rows, [(0, 2), (0, 3)], [["PICK", "WAIT"]], orders=orders)
    assert mode_of(episode) == ("unreachable", (1,))
    expected = "no path leads from robot 1 at (0, 3) to the pickup of order 1 at (0, 0)"
    assert diagnose(episode).sentence == expected
    open_order = [Order(0, 9, (0, 0), (0, 4))]
    episode = driven(rows, [(0, 2), (0, 3)], [["WAIT", "WAIT"]], orders=open_order)
    assert mode_of(episode) == ("unreachable", (0, 1))
    assert "from any robot to the pickup" in diagnose(episode).sentence


def test_an_item_that_cannot_be_delivered_is_unreachable_for_its_taker() -> None:
    orders = [Order(0, 9, (0, 0), (0, 3))]
    episode = driven(["P.#D"], [(0, 0), (0, 1)], [["PICK", "WAIT"]], orders=orders)
    assert mode_of(episode) == ("unreachable", (0,))
    assert "to the dropoff of order 0 at (0, 3)" in diagnose(episode).sentence


def test_robots_with_flat_batteries_are_named_with_the_moves_that_they_stop() -> None:
    steps = [["E", "WAIT"], ["E", "WAIT"], ["WAIT", "W"]]
    episode = driven(CORRIDOR, [(1, 2), (1, 3)], steps, battery=Battery(104, "joules"))
    assert mode_of(episode) == ("flat in the way", (0,))
    expected = "robot 0 at (1, 2) ran out of battery and blocked 1 move of other robots"
    assert diagnose(episode).sentence == expected
    episode = driven(CORRIDOR, [(1, 2), (1, 3)], steps[:2], battery=Battery(104, "joules"))
    assert mode_of(episode) == ("stranded", (0,))
    assert diagnose(episode).sentence == "robot 0 at (1, 2) ran out of battery"


def waiting(steps: int) -> FleetEpisode:
    """Return the record of robot 0, which waits on its way to a dropoff behind robot 1."""
    rows, orders = ["#P..CD#"], [Order(0, 99, (0, 1), (0, 5), robot=0)]
    moves = [["PICK", "WAIT"], ["E", "WAIT"], *[["WAIT", "WAIT"]] * steps]
    return driven(rows, [(0, 1), (0, 3)], moves, orders=orders)


@pytest.mark.parametrize(("steps", "mode"), [(9, "stranded"), (10, "flat in the way")])
def test_robots_that_wait_behind_a_flat_battery_are_named(steps: int, mode: str) -> None:
    episode = waiting(steps)
    battery = episode.battery * [1, 0]
    found = diagnose(dataclasses.replace(episode, battery=battery))
    assert (found.mode, found.robots) == (mode, (1,) if steps == 9 else (0, 1))
    blocked = "" if steps == 9 else " and blocked robot 0 at (0, 2) for the last 10 steps"
    assert found.sentence == (
        f"robot 1 at (0, 3) ran out of battery{blocked}; 1 charger, in use in 0% of the steps, can "
        "supply 5.00 times what 2 robots use"
    )


def test_a_robot_that_waits_behind_one_that_charges_is_in_no_queue() -> None:
    episode = waiting(10)
    assert mode_of(episode) == ("deadlock", (0, 1))
    battery = episode.battery.copy()
    battery[-1, 1] += 10
    assert mode_of(dataclasses.replace(episode, battery=battery))[0] == "idle"


def test_robots_that_wait_behind_a_person_are_named_with_the_cell_of_the_person() -> None:
    episode = waiting(10)
    settings = dataclasses.replace(episode.settings, robots=1, people=People(1), starts=None)
    robot = {
        name: getattr(episode, name)[:, :1]
        for name in ("cells", "loaded", "battery", "stopped_by", "actions")
    }
    people = episode.cells[:, 1:]
    found = diagnose(dataclasses.replace(episode, settings=settings, people=people, **robot))
    assert (found.mode, found.robots, found.cells) == ("people", (0,), ((0, 3),))
    assert found.sentence == (
        "robot 0 at (0, 2) was blocked by a person, at (0, 3) in the end, for the last 10 steps"
    )


def test_flat_batteries_without_a_charger_in_reach_are_named() -> None:
    orders = [Order(0, 99, (0, 0), (0, 2), robot=0)]
    for battery, mode in ((15, "no charger"), (16, "stranded")):
        episode = driven(
            ["P.D...............C"], [(0, 2)], [["WAIT"]] * battery, orders=orders, battery=battery
        )  # fmt: skip
        assert mode_of(episode) == (mode, (0,))
    episode = driven(["P.D"], [(0, 2)], [["WAIT"]] * 5, orders=orders, battery=5, max_steps=5)
    assert diagnose(episode).sentence == (
        "robot 0 at (0, 2) ran out of battery; no charger is within the 5 steps that a full "
        "battery lasts"
    )


@pytest.mark.parametrize(
    ("charge", "charging", "mode"),
    [(1, 0, "oversubscribed"), (2, 7, "stranded"), (2, 8, "oversubscribed")],
)
def test_chargers_that_supply_too_little_are_named_with_supply_and_use(
    charge: int, charging: int, mode: str
) -> None:
    orders, battery = [Order(0, 99, (0, 0), (0, 6), robot=0)], Battery(10, charge=charge)
    episode = driven(
        ["P.....DC"], [(0, 0), (0, 1)], [["WAIT"] * 2] * 10, orders=orders, battery=battery,
        max_steps=10,
    )  # fmt: skip
    measures = dataclasses.replace(episode.measures, charging=charging)
    found = diagnose(dataclasses.replace(episode, measures=measures))
    assert (found.mode, found.robots) == (mode, (0, 1))
    assert found.sentence == (
        "robot 0 at (0, 0) and robot 1 at (0, 1) ran out of battery; 1 charger, in use in "
        f"{10 * charging}% of the steps, can supply {charge / 2:.2f} times what 2 robots use"
        + ("; 1 order can no longer be delivered" if mode == "stranded" else "")
    )


@pytest.mark.parametrize(
    ("count", "wait", "mode"),
    [(4, "E", "too many orders"), (3, "E", "served"), (4, "WAIT", "idle")],
)
def test_more_orders_than_busy_robots_can_carry_are_counted(count, wait, mode) -> None:
    orders = [Order(0, 99, (0, 0), (0, 1)) for _ in range(count)]
    steps = [[action] for action in [*ROUND[:3], wait, wait, wait]]
    found = diagnose(driven(["PD...."], [(0, 0)], steps, orders=orders))
    assert found.mode == mode
    if count == 4 and wait == "E":
        assert found.sentence == (
            "4 orders came in 6 steps, and 1 robot delivered 1; 3 wait for a robot"
        )
    queue = driven(["PD...."], [(0, 0)], steps, orders=OrderQueue(4))
    assert mode_of(queue)[0] == ("idle" if mode == "idle" else "served")


def test_robots_that_stop_each_other_are_a_ring_and_others_queue_behind_it() -> None:
    # The moves of robots 0 and 2 have the same target; robot 3 follows robot 2.
    steps = [["W", "E", "E", "E"]] * 12
    episode = driven(CORRIDOR, [(1, 5), (1, 4), (1, 3), (1, 2)], steps)
    assert mode_of(episode) == ("deadlock", (0, 2))
    assert diagnose(episode).sentence == (
        "robot 0 at (1, 5) and robot 2 at (1, 3) blocked each other for the last 12 steps; "
        "waiting behind them: robot 1 at (1, 4) and robot 3 at (1, 2)"
    )


def test_robots_behind_one_that_waits_are_a_queue() -> None:
    steps = [["WAIT", "W", "W"]] * 12
    episode = driven(CORRIDOR, [(1, 2), (1, 3), (1, 5)], steps)
    assert mode_of(episode) == ("deadlock", (2, 1, 0))
    assert diagnose(episode).sentence == (
        "robot 2 at (1, 4) and robot 1 at (1, 3) were blocked by robot 0 at (1, 2), which stayed, "
        "for the last 11 steps"
    )


def corridor(first: str, second: str) -> str:
    """Return the mode of two robots side by side that carry out these actions, a letter each."""
    words = {".": "WAIT"}
    steps = [[words.get(a, a), words.get(b, b)] for a, b in zip(first, second, strict=True)]
    return mode_of(driven(CORRIDOR, [(1, 2), (1, 3)], steps))[0]


@pytest.mark.parametrize(("steps", "is_deadlock"), [(9, False), (10, True)])
def test_a_deadlock_takes_ten_steps(steps: int, is_deadlock: bool) -> None:
    assert (corridor("." * steps, "W" * steps) == "deadlock") == is_deadlock
    # The second robot stands for longer, the first one is in its way for these steps only.
    came = corridor("WE" + "." * steps, ".." + "W" * steps)
    assert (came == "deadlock") == is_deadlock


@pytest.mark.parametrize(("stops", "is_deadlock"), [(8, False), (9, False), (10, True)])
def test_a_robot_that_is_stopped_in_half_of_the_steps_is_in_a_queue(stops, is_deadlock) -> None:
    # The other half is shared by waits and bumps into a wall, so that the stops are most frequent.
    waits, bumps = (20 - stops) // 2, 20 - stops - (20 - stops) // 2
    assert (
        corridor("." * 20, "W" * stops + "." * waits + "N" * bumps) == "deadlock"
    ) == is_deadlock


def test_a_robot_behind_a_person_is_in_no_queue() -> None:
    episode = driven(CORRIDOR, [(1, 2), (1, 3)], [["WAIT", "W"]] * 12)
    assert mode_of(episode) == ("deadlock", (1, 0))
    people = np.where(episode.stopped_by == 0, 2, episode.stopped_by)
    behind = dataclasses.replace(episode, stopped_by=people)
    assert mode_of(behind)[0] == "people"
    assert diagnose(behind).sentence == (
        "12 of 12 moves were blocked by people; the worst cell is (1, 3), with 12"
    )


def starved(
    later: int, released: int = 1, pick_at: int | None = None, due: int = 40
) -> tuple[str, Any]:
    """Return mode and robots where an order waits, later ones do not, and ``pick_at`` ends it."""
    rows = ["P..", "PD."]
    early = Order(0, due, (0, 0), (1, 1))
    others = [Order(released, 99, (1, 0), (1, 1), robot=0) for _ in range(later)]
    steps = [["WAIT", "WAIT"]] + [[action, "WAIT"] for action in ROUND * 10]
    if pick_at is not None:
        steps[pick_at][1] = "PICK"
    return mode_of(driven(rows, [(1, 0), (0, 0)], steps, orders=[early, *others]))


def test_an_order_that_ten_later_ones_overtake_starves() -> None:
    assert starved(10) == ("overtaken order", ())
    assert starved(9)[0] != "overtaken order"
    assert starved(10, released=0)[0] != "overtaken order"
    tenth = 1 + 4 * 9
    assert starved(10, pick_at=tenth)[0] != "overtaken order"
    assert starved(10, pick_at=tenth + 1) == ("overtaken order", (1,))


def test_an_order_that_is_not_late_does_not_starve_however_many_overtake_it() -> None:
    assert starved(10, due=41)[0] == "idle", "the episode has 41 steps"
    rows, early = ["P..", "PD."], Order(0, 45, (0, 0), (1, 1))
    later = [Order(1, 99, (1, 0), (1, 1), robot=0) for _ in range(11)]  # the last is not delivered
    steps = [["WAIT", "WAIT"]] + [[action, "WAIT"] for action in ROUND * 10]
    ending = [["N", action] for action in ("PICK", "E", "S", "DROP", "WAIT")]
    starts = [(1, 0), (0, 0)]
    for due in (44, 45):
        episode = driven(rows, starts, steps + ending, orders=[early._replace(due=due), *later])
        assert (mode_of(episode)[0] == "overtaken order") == (due == 44)


def test_the_order_that_starves_is_named() -> None:
    rows, early = ["P..", "PD."], Order(0, 40, (0, 0), (1, 1))
    later = [Order(1, 99, (1, 0), (1, 1), robot=0) for _ in range(10)]
    steps = [["WAIT", "WAIT"]] + [[action, "WAIT"] for action in ROUND * 10]
    found = diagnose(driven(rows, [(1, 0), (0, 2)], steps, orders=[early, *later]))
    said = "order 0 at (0, 0), due at step 40, waited for 41 steps while 10 orders"
    assert said in found.sentence
    assert (found.cells, found.steps) == (((0, 0),), 41)


@pytest.mark.parametrize(("free_moves", "mode"), [(3, "congested"), (4, "served")])
def test_a_quarter_of_the_moves_stopped_by_robots_is_congestion(free_moves: int, mode: str) -> None:
    steps = [["E", "W"], ["W", "E"], ["E", "W"], ["W", "E"], ["E", "W"]]
    episode = driven(HALL, [(2, 2), (2, 3)], steps[: free_moves + 1])
    assert mode_of(episode) == (mode, (0, 1))
    if mode == "congested":
        assert diagnose(episode).sentence == (
            "2 of 8 moves were blocked by robots or people; the worst cell is (2, 2), with 1"
        )


@pytest.mark.parametrize(("waits", "mode"), [(10, "idle"), (9, "served")])
def test_a_fleet_that_waits_half_of_the_time_is_idle(waits: int, mode: str) -> None:
    steps = ([["WAIT", "WAIT"]] * waits + [["E", "E"], ["W", "W"]] * 6)[:20]
    episode = driven(HALL, [(1, 2), (2, 2)], steps)
    assert mode_of(episode) == (mode, (0, 1))
    if mode == "idle":
        assert diagnose(episode).sentence == (
            "the robots waited in 20 of 40 steps, with 0 orders for 2 robots"
        )


@pytest.mark.parametrize(
    ("dues", "sentence"),
    [
        ([2], "1 of 1 deliveries were late; the mean lateness of all deliveries is 1 step"),
        ([2, 6], "2 of 2 deliveries were late; the mean lateness of all deliveries is 1 step"),
        ([2, 7], "2 of 2 orders delivered in 7 steps"),
        ([3], "1 of 1 order delivered in 3 steps"),
    ],
)
def test_a_fleet_is_late_if_more_than_half_of_its_deliveries_are(dues, sentence) -> None:
    orders = [Order(0, due, (0, 0), (0, 1)) for due in dues]
    steps = [[action] for action in ROUND * 2]
    episode = driven(["PD"], [(0, 0)], steps, orders=orders)
    assert mode_of(episode) == ("late" if "late" in sentence else "served", (0,))
    assert diagnose(episode).sentence == sentence


def test_robots_that_failed_are_counted() -> None:
    episode = driven(HALL, [(1, 2), (2, 2)], [["E", "E"], ["W", "W"]])
    measures = dataclasses.replace(episode.measures, stranded=2, lost=1)
    failed = diagnose(dataclasses.replace(episode, measures=measures))
    assert (failed.mode, failed.robots) == ("stranded", ())
    assert failed.sentence == "2 robots failed permanently; 1 order can no longer be delivered"


def test_a_fleet_that_has_delivered_everything_was_not_idle() -> None:
    steps = [["WAIT"]] * 6 + [[action] for action in ROUND]
    episode = driven(["PD"], [(0, 0)], steps, orders=[Order(0, 99, (0, 0), (0, 1))])
    assert mode_of(episode) == ("served", (0,))
    assert mode_of(driven(["PD"], [(0, 0)], steps[:-2], orders=episode.orders[:1]))[0] == "idle"
