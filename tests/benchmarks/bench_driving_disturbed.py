"""Fleets that drive through, nominally and with disturbances: all orders delivered, and nobody hit.

Each fleet carries out the same list of orders nominally, with 5% noise and one stop of 60 s, and
with two robots that fail for good.
"""

import math

import numpy as np
import pytest

from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv
from warehouse_core.fleet import Battery, FleetMeasures
from warehouse_core.orders.order import Order
from warehouse_core.world.generators import shelf_layout
from warehouse_physics import Disturbances, DrivingMotion, Stop

LAYOUTS = {
    32: shelf_layout(5, 6, 4, 2, 2, pickups=16, dropoffs=8),
    100: shelf_layout(8, 10, 4, 2, 2, pickups=48, dropoffs=24),
}
"""By number of robots, with 14 cells or more and a quarter of a dropoff for each."""

ORDERS_OF_A_ROBOT, MAX_STEPS, LATE = 2, 1200, 100_000
STOP = 60.0
NOISY = Disturbances(actuation_noise=0.05, stops=(Stop(0, 20.0, STOP),))
FAILING = Disturbances(stops=(Stop(1, 20.0, math.inf), Stop(2, 40.0, math.inf)))


def shift(
    planner: str, robots: int, seed: int, disturbances: Disturbances
) -> tuple[FleetMeasures, int]:
    """Return measures and hits."""
    stream, layout = np.random.default_rng(seed), LAYOUTS[robots]
    count = robots * ORDERS_OF_A_ROBOT
    ends = (stream.integers(len(each), size=count) for each in (layout.pickups, layout.dropoffs))
    orders = [
        Order(0, LATE, layout.pickups[pickup], layout.dropoffs[dropoff])
        for pickup, dropoff in zip(*(each.tolist() for each in ends), strict=True)
    ]
    env = FleetEnv(
        layout,
        robots,
        backend=DrivingMotion(disturbances=disturbances, record_path=False),
        orders=orders,
        max_steps=MAX_STEPS,
        battery=Battery(1_000_000),
        dispatch=False,
    )
    agent = make_fleet_agent(planner, "urgent", seed, layout, robots)
    env.reset(seed)
    agent.reset()
    hits = 0
    while not all(env.ended):
        env.step(agent.act(env))
        hits += sum(len(outcome.contacts) for outcome in env.last_motion)
    return env.measures, hits


@pytest.mark.parametrize("planner", ["windowed-lanes", "pibt-lanes"])
@pytest.mark.parametrize("robots", LAYOUTS)
@pytest.mark.parametrize("seed", [0, 1])
def test_disturbed_fleets_deliver_every_order_in_time_and_hit_nobody(
    planner: str, robots: int, seed: int, measured
) -> None:
    nominal, _ = shift(planner, robots, seed, Disturbances())
    noisy, noisy_hits = shift(planner, robots, seed, NOISY)
    failing, failing_hits = shift(planner, robots, seed, FAILING)
    name = f"{planner}, {robots} robots, seed {seed}"
    measured(f"{name}: nominal makespan", f"{nominal.seconds:.0f} s")
    share = (noisy.seconds - STOP) / nominal.seconds
    measured(
        f"{name}: with noise and a stop",
        f"{noisy.seconds:.0f} s, {share:.2f} of it without the stop, {noisy_hits} hits",
    )
    measured(
        f"{name}: with two failures",
        f"{failing.seconds:.0f} s, {failing.lost} of {failing.orders} items lost, "
        f"{failing_hits} hits",
    )
    assert nominal.delivered == nominal.orders
    assert (noisy.delivered, noisy_hits) == (noisy.orders, 0)
    assert share <= 1.3
    assert failing.delivered + failing.lost == failing.orders
    assert failing_hits == 0
    assert failing.stranded == 2
