"""The order of events in a step, and their effects on robots."""

import math
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import DROP, EAST, FLY, NORTH, PICK, SOUTH, WAIT, WEST, plain, state_of

from warehouse_core import FleetEnv, GridMotion, Layout, Order, Outcome
from warehouse_core.errors import EndedError
from warehouse_core.fleet import Battery
from warehouse_core.motion.grid import nominal_joules
from warehouse_core.task import rules

AISLE = Layout(["......C"])
SHOP = Layout(["P...D", "....C"])
IDLE, MOVE = (round(nominal_joules(1.0, moving=moving)) for moving in (False, True))


def begun(*args: Any, **settings: Any) -> FleetEnv:
    fleet = FleetEnv(*args, **settings)
    fleet.reset(seed=settings.get("seed", 1))
    return fleet


def shop(*orders: Order, robots: int = 2, **settings: Any) -> FleetEnv:
    starts = [(1, col) for col in range(robots)]
    return begun(SHOP, robots, **({"orders": orders, "starts": starts} | settings))


def order(due: int = 50, released: int = 0, robot: int | None = None, **cells: Any) -> Order:
    return Order(released, due, cells.get("pickup", (0, 0)), (0, 4), robot)


def test_an_order_is_released_when_its_step_has_been_reached() -> None:
    fleet = shop(order(released=0), order(released=2), robots=1)
    for released in (1, 1, 2):
        assert len(fleet.orders) == released
        fleet.step([WAIT])


def test_the_rules_judge_each_robot_where_it_is_after_the_motion() -> None:
    fleet = begun(["P.D", "#.#"], 2, starts=[(0, 0), (1, 1)])
    _, rewards, terminated, truncated, info = fleet.step([PICK, WEST])
    assert rewards.tolist() == [
        rules.STEP_REWARD + rules.PICK_REWARD,
        rules.STEP_REWARD + rules.BLOCKED_REWARD,
    ]
    assert fleet.loaded == [True, False]
    assert not (terminated | truncated).any()
    assert info["motion"]["stopped_by"].tolist() == [-1, -2]
    arrays, rewards, _, _, info = fleet.step([EAST, FLY])
    assert fleet.cells == [(0, 1), (1, 1)]
    assert info["invalid_action"].tolist() == [False, True]
    assert rewards[1] == rules.STEP_REWARD + rules.MISTAKE_REWARD
    assert arrays["robot_pos"].tolist() == [[0, 1], [1, 1]]
    assert [len(info["motion"][key]) for key in info["motion"]] == [2] * 4


def test_a_charger_saves_a_robot_with_its_last_unit_and_fills_it_no_more_than_full() -> None:
    fleet = begun(AISLE, 2, starts=[(0, 6), (0, 0)], battery=3)
    fleet.step([NORTH, WAIT])
    fleet.step([NORTH, WAIT])
    assert fleet.battery == [1, 1]
    truncated = fleet.step([WAIT, WAIT])[3]
    assert (fleet.battery, truncated.tolist()) == ([3, 0], fleet.ended) == ([3, 0], [False, True])
    fleet = begun(AISLE, 1, starts=[(0, 6)], battery=Battery(100, charge=30), max_steps=99)
    units = []
    for action in [NORTH] * 50 + [WAIT] * 3:
        fleet.step([action])
        units += fleet.battery
    assert units[-4:] == [50, 79, 100, 100]


@pytest.mark.parametrize("knee", [0.8, 0.25, 1e-6])
def test_a_charge_has_a_constant_current_up_to_its_knee_and_then_one_that_falls(knee) -> None:
    battery, units, fine = Battery(1000, knee=knee), np.array([0.0, 640.0, 1000.0]), 500
    for _ in range(30):
        current = units
        for _ in range(fine):  # Euler's method for the law that the docstring states
            share = np.minimum((1000 - current) / (1000 * (1 - knee)), 1.0)
            current = current + 45 / fine * share
        units = units + battery.supplied(1000 - units, 45.0)
        assert units == pytest.approx(current, abs=0.1)
        assert (units <= 1000).all()


def test_a_robot_with_an_empty_battery_blocks_others() -> None:
    fleet = begun(
        ["......"], 2, starts=[(0, 3), (0, 0)], battery=Battery(25, "joules"), max_steps=9
    )
    # A wait costs 20 J, a move more than 25 J.
    _, _, terminated, truncated, _ = fleet.step([EAST, WAIT])
    assert (terminated.tolist(), truncated.tolist()) == ([False] * 2, [True, False])
    before = fleet.battery
    _, rewards, _, truncated, _ = fleet.step([WEST, EAST])
    assert (fleet.cells, rewards[0], fleet.battery[0]) == ([(0, 4), (0, 1)], 0.0, before[0])
    assert truncated.tolist() == [True, True]
    assert fleet.measures.stranded == 2
    with pytest.raises(EndedError, match=r"^step\(\) needs a reset\(\) before it: all robots have"):
        fleet.step([WAIT, WAIT])
    fleet.reset()
    assert fleet.battery == [25, 25]


def test_of_two_robots_over_one_cell_the_lower_number_is_served_first() -> None:
    class Together(GridMotion):
        """Two bodies come to rest over the same cell."""

        def fleet_batch(self, *_: Any) -> Any:
            raise ValueError("bodies")

        def advance(self, displacements: Any, loaded: Any) -> Any:
            return [Outcome((0, 0), False, 1.0, 1.0, np.zeros((2, 4))) for _ in loaded]

    fleet = shop(order(due=9), order(due=5), robots=3, backend=Together, dispatch=False)
    _, rewards, _, _, _ = fleet.step([PICK, WAIT, PICK])
    assert fleet.order_of == [1, None, 0]
    assert rewards[0] == rewards[2] == rules.STEP_REWARD + rules.PICK_REWARD
    fleet = shop(order(), robots=3, backend=Together, dispatch=False)
    _, rewards, _, _, _ = fleet.step([PICK, PICK, PICK])
    assert (fleet.loaded, fleet.order_of) == ([True, False, False], [0, None, None])
    assert rewards.tolist() == [4.9, -0.6, -0.6]


def test_open_orders_wait_for_all_and_are_seen() -> None:
    fleet = shop(order(), robots=2, dispatch=False)
    assert (fleet.open_orders, fleet.order_of) == ([0], [None, None])
    seen = fleet.observe(1)
    assert (seen["pickup_pos"], seen["dropoff_pos"], seen["due"]) == (None, None, None)
    assert seen["local_grid"][1] == "#P..."
    assert seen["local_grid"][2] == "#OR.."
    arrays, _, _, _, info = fleet.step([NORTH, WAIT])
    assert info["action_mask"][:, PICK].tolist() == [1, 0]
    assert fleet.observe(1)["local_grid"][1] == "#O..."
    fleet.step([PICK, WAIT])
    assert fleet.observe(1)["local_grid"][1] == "#o..."
    assert (fleet.open_orders, fleet.order_of, fleet.observe(0)["due"]) == ([], [0, None], 50)
    fleet.step([EAST, WAIT])
    assert fleet.observe(1)["local_grid"][1] == "#.o.."
    assert arrays["due"].tolist() == [[-1], [-1]]


def test_the_orders_released_so_far_are_seen_as_arrays() -> None:
    orders = [Order(0, 50, (0, 0), (0, 3)), Order(2, 60, (0, 3), (0, 0), 1)]
    fleet = FleetEnv(["...."], 2, orders=orders, starts=[(0, 1), (0, 2)], max_steps=9)
    fleet.reset(seed=1)
    assert [column.tolist() for column in fleet.order_arrays] == [[0], [50], [0], [3], [-1]]
    for _ in range(2):
        fleet.step([WAIT, WAIT])
    assert [column.tolist() for column in fleet.order_arrays] == [
        [0, 2], [50, 60], [0, 3], [3, 0], [-1, 1]
    ]  # fmt: skip
    with pytest.raises(ValueError, match="this fleet has no orders"):
        _ = FleetEnv(["...."], 2).order_arrays


def test_a_delivery_late_costs_its_penalty_and_the_list_ends_with_the_last_one() -> None:
    fleet = begun(
        ["PD"], 2, orders=[Order(0, 1, (0, 0), (0, 1))], starts=[(0, 0), (0, 1)], late_penalty=0.25
    )
    fleet.step([PICK, WAIT])
    assert fleet.step([WAIT, EAST])[1].tolist() == pytest.approx([-0.15, -1.1])
    fleet = shop(Order(0, 3, (1, 0), (1, 1)), robots=1, late_penalty=0.25)
    for action in (PICK, NORTH, EAST, SOUTH):
        fleet.step([action])
    _, rewards, terminated, truncated, _ = fleet.step([DROP])
    assert rewards.tolist() == [rules.STEP_REWARD + rules.DROP_REWARD - 2 * 0.25]
    assert (terminated.tolist(), truncated.tolist()) == ([True], [False])
    record = fleet.orders[0]
    assert (record.taken_by, record.taken, record.delivered) == (0, 1, 5)


def test_a_team_shares_its_rewards() -> None:
    alone, team = (
        begun(["P.D", "#.#"], 2, starts=[(0, 0), (1, 1)], team_reward=each)
        for each in (False, True)
    )
    actions = [PICK, WEST]
    expected = alone.step(actions)[1]
    assert team.step(actions)[1].tolist() == [expected.mean()] * 2
    assert expected[0] != expected[1]


@pytest.mark.parametrize("dispatch", [False, True])
def test_a_stranded_robot_gives_its_order_back_in_the_same_step(dispatch: bool) -> None:
    settings: Any = {"battery": Battery(25, "joules"), "dispatch": False}
    fleet = shop(order(), order(pickup=(0, 2)), **settings)
    fleet.assign(1, 0)
    fleet._engine.orders._dispatches = dispatch  # type: ignore[union-attr]
    # Robot 1 moves, which empties its battery; robot 0 waits, and has 5 J left.
    truncated = fleet.step([WAIT, EAST])[3]
    assert truncated.tolist() == [False, True]
    assert (fleet.order_of, fleet.open_orders) == (
        ([0, None], [1]) if dispatch else ([None, None], [0, 1])
    )


@pytest.mark.parametrize("is_listed", [True, False])
def test_when_all_items_that_are_left_are_lost_a_list_is_over_and_not_done(is_listed: bool) -> None:
    listed = order(pickup=(1, 1)), Order(0, 50, (1, 0), (0, 0))
    orders: Any = {} if is_listed else {"orders": 0.0}
    fleet = shop(*listed, battery=Battery(IDLE + 2 * MOVE - 1, "joules"), dispatch=False, **orders)
    assert not any(np.any(fleet.step(each)[2:4]) for each in ([PICK, PICK], [NORTH, EAST]))
    _, _, terminated, truncated, _ = fleet.step([DROP, EAST])
    assert truncated.tolist() == [is_listed, True]
    assert not terminated.any()
    assert (fleet.measures.delivered, fleet.measures.lost) == (is_listed, is_listed)


def test_actions_come_as_a_list_an_array_or_a_mapping() -> None:
    forms: list[Any] = [
        ["pick", "E"], ("PICK", 1), np.array([5, 1]), np.array([5, 1], np.uint8),
        np.array(["Pick", "e"], object), {1: "E", 0: 5}, {0: np.int64(5), np.int64(1): "e"},
    ]  # fmt: skip
    results = []
    for actions in forms:
        fleet = begun(["P..", "..D"], 2, starts=[(0, 0), (1, 0)])
        results.append((plain(fleet.step(actions)), state_of(fleet)))
    assert all(each == results[0] for each in results[1:])
    for actions in (
        ["pick", 9],
        np.array([5, -1]),
        {0: 5, 1: 2**70},
        np.array([5, 2**64 - 1], np.uint64),
    ):
        fleet = begun(["P..", "..D"], 2, starts=[(0, 0), (1, 0)])
        assert fleet.step(actions)[4]["invalid_action"].tolist() == [False, True]


def test_a_robot_on_a_charger_is_charged_past_the_knee() -> None:
    battery = Battery(100, charge=30, knee=0.5)
    fleet = begun(AISLE, 1, starts=[(0, 6)], battery=battery, max_steps=99)
    assert fleet.state_of_charge == [1.0]
    for action in [NORTH] * 50 + [WAIT]:
        fleet.step([action])
    missing = 50 * math.exp(-29 / 50)  # the first of 30 units is at a constant current
    assert fleet.state_of_charge == pytest.approx([1 - missing / 100])
    fleet.step([WAIT])
    assert fleet.battery == pytest.approx([100 - (missing + 1) * math.exp(-30 / 50)])
