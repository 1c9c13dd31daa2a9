"""What is lost to a robot that stops for a minute, in the order of the plan and with switches.

``WAREHOUSE_PLANS`` is the number of plans of each planner. Robots have 5% noise, and one of them
stops for 60 s in the first minute. What is lost are the seconds by which all robots but that one
arrive later, taken together, than without any disturbance. A part of that is lost to the noise
alone, and some robots have to go through the cell where the robot stands: no order wins that back.
"""

import os

import numpy as np
import pytest
from benchmarks.bench_driving import LAYOUT, plan_of
from helpers.passing_order import on_small_plan

from agents.mapf.execution import Execution, drive_through
from warehouse_physics import Disturbances, Stop

PLANS = int(os.environ.get("WAREHOUSE_PLANS", "1"))
NOISE, SECONDS, WITHIN = 0.05, 60.0, (10.0, 60.0)
SMALL = 100
"""Small plans for which the best order is known."""


@pytest.mark.parametrize("robots", [32, 100])
@pytest.mark.parametrize("name", ["pibt", "windowed"])
def test_switches_win_back_a_part_of_what_is_lost(name: str, robots: int, measured) -> None:
    lost = np.zeros(3)
    for seed in range(PLANS):
        plan, stream = plan_of(name, robots, seed), np.random.default_rng(seed)
        stop = Stop(int(stream.integers(robots)), float(stream.uniform(*WITHIN)), SECONDS)
        trouble = Disturbances(actuation_noise=NOISE, stops=(stop,))
        others = np.arange(robots) != stop.robot

        def later(run: Execution, than: Execution, others: np.ndarray = others) -> float:
            assert run.hits == 0
            return float((run.arrivals - than.arrivals)[others].sum())

        nominal = drive_through(LAYOUT, plan)
        assert later(drive_through(LAYOUT, plan, switches=True), nominal) == 0.0
        runs = (
            drive_through(LAYOUT, plan, None, Disturbances(actuation_noise=NOISE)),
            drive_through(LAYOUT, plan, None, trouble),
            drive_through(LAYOUT, plan, None, trouble, switches=True),
        )
        lost += [later(run, nominal) for run in runs]
    noise, kept, switched = lost / PLANS / (robots - 1)
    measured(
        f"passing order with a stop of 60 s, {name}, {robots} robots, {PLANS} plans",
        f"others arrive {kept:.1f} s later in the order of the plan, {switched:.1f} s with "
        f"switches, {noise:.1f} s with noise alone; {1 - switched / kept:.0%} won back, "
        f"{(kept - switched) / (kept - noise):.0%} of what the stop costs",
    )
    assert switched < kept


def test_the_search_beside_the_best_order_of_small_plans(measured) -> None:
    before, after, best = np.array([on_small_plan(seed) for seed in range(SMALL)]).T
    late = (after > best + 1e-6).sum()
    measured(
        f"passing order beside the best, by HiGHS, {SMALL} plans of 4 robots, one 20 s late",
        f"{(before - after).sum():.0f} of {(before - best).sum():.0f} s won back that any order "
        f"can, {(before - after).sum() / (before - best).sum():.0%}; worse than the best in "
        f"{late} plans",
    )
    assert (best <= after + 1e-6).all()
