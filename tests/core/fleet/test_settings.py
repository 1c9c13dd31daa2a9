"""Bad input raises a clear error, and changes nothing."""

import warnings
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import WAIT, state_of

from warehouse_core import FleetEnv, Layout, LayoutError, Order, OrderError, OrderStream
from warehouse_core.fleet import Battery, People

SHOP = Layout(["P..D", "#..C"])
ORDER = Order(0, 9, (0, 0), (0, 3))


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"robots": 8}, LayoutError, "^8 robots and 0 people do not fit on the 7 open cells"),
        ({"people": 6}, LayoutError, "^2 robots and 6 people do not fit on the 7 open cells"),
        ({"starts": [(0, 1)]}, ValueError, "^1 starts for 2 robots; each needs one$"),
        (
            {"starts": [(0, 1), (0, 1)]},
            LayoutError,
            r"^robots 0 and 1 are both placed in \(0, 1\)$",
        ),
        ({"starts": [(0, 1), (1, 0)]}, LayoutError, "^robot 1: row 1, column 0 is wall; it must"),
        (
            {"starts": [(0, 1), "ab"]},
            TypeError,
            "^the start of robot 1 is 'ab'; it must be two int",
        ),
        ({"orders": 1e9}, OrderError, "^the rate 1000000000 leads to about"),
        (
            {"orders": True},
            TypeError,
            "^orders are True; allowed: a rate, an OrderStream, an Order",
        ),
        ({"orders": []}, TypeError, r"^orders are \[\]; allowed: .*, with at least one$"),
        ({"orders": [ORDER, OrderStream()]}, TypeError, r"^orders are \[Order\(.*; allowed"),
        (
            {"orders": [ORDER._replace(pickup=(1, 0))]},
            OrderError,
            "^order 0: pickup row 1, column 0",
        ),
        ({"orders": [ORDER._replace(robot=2)]}, OrderError, r"^order 0: robot 2; allowed: 0..1"),
        ({"orders": [ORDER._replace(due=-1)]}, OrderError, "^order 0: released at 0 and due at -1"),
        ({"orders": OrderStream(pickup_weights=(1, 2))}, OrderError, "^2 pickup_weights for the l"),
        ({"layout": ["P."], "orders": 0.1, "robots": 1}, LayoutError, "^the layout has no dropoff"),
    ],
)
def test_a_fleet_names_what_is_wrong(settings: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        FleetEnv(**({"layout": SHOP, "battery": 500} | settings))


def test_memory_is_bounded_before_it_is_used(little_memory: Any) -> None:
    """The layouts or the robots set the limit, whichever need more memory."""
    with little_memory():
        for robots, radius in ((1, 1000), (3000, 120)):
            with pytest.raises(
                LayoutError, match="bytes; MAX_TABLE_BYTES = 1073741824 are allowed"
            ):
                FleetEnv(["." * 60] * 60, robots, view_radius=radius)


@pytest.fixture
def fleet() -> FleetEnv:
    fleet = FleetEnv(SHOP, 2, orders=[ORDER, ORDER], people=1, dispatch=False, seed=1)
    fleet.reset()
    fleet.step([WAIT, WAIT])
    return fleet


@pytest.mark.parametrize(
    ("actions", "error", "message"),
    [
        (["N"], ValueError, r"^actions have the shape \(1,\); they must have the shape \(2,\)"),
        (np.zeros((2, 1), int), ValueError, r"^actions have the shape \(2, 1\)"),
        ({0: "N", 2: "N"}, ValueError, r"^an action for robot 2; allowed: 0..1$"),
        ({0: "N", 1: "N", "1": "N"}, ValueError, "^an action for robot '1'"),
        ({1: "N"}, ValueError, "^robot 0 has no action; every robot that has not ended needs one$"),
        ("NE", TypeError, "^actions are 'NE'; allowed: a sequence, an array or a mapping$"),
        (["N", 1.0], TypeError, r"^action 1.0 is float; allowed: one of N, E,"),
    ],
)
def test_bad_actions_change_nothing(fleet, actions, error, message) -> None:
    before = state_of(fleet)
    with pytest.raises(error, match=message):
        fleet.step(actions)
    assert state_of(fleet) == before


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda fleet: fleet.reset(seed=-1), ValueError, "^seed is -1"),
        (lambda fleet: fleet.observe(2), ValueError, "^robot is 2; it must be at most 1$"),
        (lambda fleet: fleet.assign(2, 0), ValueError, "^robot is 2"),
        (lambda fleet: fleet.assign(0, 2), OrderError, "^order 2 cannot be assigned to robot 0: 2"),
        (lambda fleet: fleet.assign(0, -1), OrderError, "^order -1 cannot be assigned"),
    ],
)
def test_bad_calls_change_nothing(fleet: FleetEnv, call: Any, error: Any, message: str) -> None:
    before = state_of(fleet)
    with pytest.raises(error, match=message):
        call(fleet)
    assert state_of(fleet) == before


def test_only_robots_of_orders_that_have_not_ended_are_assigned() -> None:
    fleet = FleetEnv(["PD"], 1)
    fleet.reset()
    with pytest.raises(ValueError, match=r"^order 0 for robot 0: this fleet has no orders$"):
        fleet.assign(0, 0)
    assert (fleet.orders, fleet.open_orders, fleet.order_of) == ([], [], [None])
    fleet = FleetEnv(SHOP, 2, orders=[ORDER], battery=Battery(25, "joules"), max_steps=1)
    fleet.reset(seed=1)
    fleet.step([0, 0])
    with pytest.raises(OrderError, match=r"^order 0 for robot 1: this robot has ended$"):
        fleet.assign(1, 0)


def test_too_few_chargers_are_warned_of() -> None:
    with pytest.warns(UserWarning, match="1 charger can keep 10 of 11 robots running, and"):
        FleetEnv(["....C.", "......"], 11, max_steps=300)
    with pytest.warns(
        UserWarning,
        match="^0 chargers can keep 0 of 2 robots running, and a full battery lasts [0-9]+ of ",
    ):
        FleetEnv(["P..D"], 2, orders=0.1, battery=Battery(500, "joules"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        FleetEnv(["....C.", "......"], 10, max_steps=300)
        FleetEnv(["....C.", "......"], 11, max_steps=200)
        FleetEnv(["P..D"], 2, max_steps=300)


def test_a_seed_is_for_the_first_reset_without_one() -> None:
    starts = []
    for given, at_reset in ((7, None), (None, 7), (3, 7)):
        fleet = FleetEnv(["........"] * 8, 5, seed=given)
        fleet.reset(at_reset)
        starts.append(fleet.cells)
        fleet.reset()
        starts.append(fleet.cells)
    assert starts[0:2] == starts[2:4] == starts[4:6]
    assert starts[0] != starts[1]


def test_a_fleet_says_what_it_is_and_closes_its_backend() -> None:
    fleet = FleetEnv(SHOP, 2, people=People(1))
    assert repr(fleet).startswith("<FleetEnv 2 robots, 2 x 4")
    fleet.reset(seed=1)
    with pytest.raises(RuntimeError, match=r"outcomes\(\) needs an advance\(\)"):
        _ = fleet.last_motion
    fleet.close()
    with pytest.raises(RuntimeError):
        fleet.step([0, 0])
    assert FleetEnv().layout.rows == FleetEnv(None, 2).layout.rows
