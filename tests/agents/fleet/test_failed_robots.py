"""Fleets whose robots drive through continue without robots that fail."""

import math

import pytest
from helpers.fleets import SHELVES

from agents.lab.commands.fleet.report import result_of, verdict
from agents.registry import make_fleet_agent
from warehouse_core import Cell, FleetEnv, Order, record_fleet_episode
from warehouse_core.batch.fleet_settings import JOULES
from warehouse_core.fleet import Battery
from warehouse_core.records.episode import FleetEpisode
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

UPPER, LOWER = SHELVES.pickups
STARTS = [LOWER, (1, 7), (7, 7), (4, 1)]
ORDERS = [
    Order(step, 200, pickup, dropoff)
    for step, pickup, dropoff in zip(
        (0, 0, 0, 5, 10, 15), (LOWER, LOWER, UPPER) * 2, SHELVES.dropoffs * 3, strict=True
    )
]


def shift(env: FleetEnv, planner: str = "pibt") -> FleetEpisode:
    """Return a shift, after checking that it has no hits and that only lost items are missing."""
    agent = make_fleet_agent(planner, layout=env.layout, robots=env.settings.robots)
    episode = record_fleet_episode(env, agent, seed=0)
    measures = episode.measures
    assert not any(outcome.contacts for each in episode.motions for outcome in each)
    assert measures.delivered + measures.lost == measures.orders == len(ORDERS)
    assert measures.stranded == 1
    assert measures.steps < env.settings.max_steps
    return episode


def failing(at: float, start: Cell = STARTS[0], planner: str = "pibt") -> tuple[FleetEpisode, Cell]:
    """Return a shift in which the first robot fails, and the cell in which it fails."""
    stops = Disturbances(stops=(Stop(0, at, math.inf),))
    env = FleetEnv(
        SHELVES, 4, starts=[start, *STARTS[1:]], orders=ORDERS, max_steps=150, dispatch=False,
        backend=DrivingMotion(RobotSpec.fast(), stops),
    )  # fmt: skip
    episode = shift(env, planner)
    assert env.ended[0]
    return episode, env.cells[0]


@pytest.mark.parametrize("planner", ["pibt", "windowed:guidance=lanes,groups=2"])
def test_an_item_is_lost_with_the_robot_that_carries_it_in_an_aisle(planner: str) -> None:
    episode, (row, col) = failing(4.0, planner=planner)
    assert (row, col) not in SHELVES.pickups + SHELVES.dropoffs
    assert episode.measures.lost == 1
    [lost] = [order for order in episode.orders if order.delivered is None]
    assert (lost.taken_by, lost.pickup) == (0, LOWER)
    result = result_of(episode)
    sentence = result.diagnosis.sentence
    assert sentence == "1 robot failed permanently; 1 order can no longer be delivered"
    said = verdict([result.measures], 4)
    assert "5 of 6 orders delivered" in said
    assert "Orders lost with these robots: 1." in said


def test_a_station_is_reached_from_another_side_than_where_a_robot_failed() -> None:
    beside = LOWER[0], LOWER[1] - 1
    episode, cell = failing(0.0, beside)
    assert cell == beside
    assert episode.measures.lost == 0
    assert 0 not in {order.taken_by for order in episode.orders}


@pytest.mark.filterwarnings("ignore:0 chargers")
def test_a_robot_stops_where_its_battery_becomes_flat() -> None:
    orders = [Order(0, 50, (0, 7), (1, 7))]
    env = FleetEnv(
        ["." * 7 + "P", "." * 7 + "D"], 2, starts=[(0, 0), (1, 0)], orders=orders,
        battery=Battery(150, JOULES), backend=DrivingMotion(), dispatch=False,
    )  # fmt: skip
    env.reset(seed=0)
    env.assign(0, 0)
    while not env.ended[0]:
        assert env.routes.failed == [False, False]
        env.step(["E", "WAIT"])
    assert (env.battery[0], env.ended[1]) == (0.0, False)
    assert env.routes.failed == [True, False]
    assert (env.order_of, env.open_orders, env.measures.stranded) == ([None, None], [0], 1)
    env.step(["E", "WAIT"])
    cell = env.cells[0]
    assert 1 <= cell[1] < 7
    assert cell in env.routes.closed
    env.step(["E", "WAIT"])
    path = env.last_motion[0].path
    assert path[0, 1:3].tolist() == path[-1, 1:3].tolist()
