"""Comparison of task assignments with each other and with the optimum.

The layout is a warehouse of 33 x 46 cells with 16 chargers. There are always two orders per robot.
"""

import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.fleet.optimum import most_deliveries
from agents.lab.trials.interval import Interval, mean_interval
from agents.mapf.assignment import ASSIGNMENTS
from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, Layout, OrderQueue, OrderStream, record_fleet_episode
from warehouse_core.fleet import FleetMeasures
from warehouse_core.world.generators import benchmark_warehouse
from warehouse_core.world.named_layouts import DEPOT, find_layout
from warehouse_core.world.tiles import WALL

ROBOTS, STEPS, SEEDS = 96, 1000, range(20)
PLANNER = "pibt:guidance=lanes"
DUE = (60, 240)


def warehouse() -> Layout:
    """Return blocks of shelves with pickups above them, and dropoffs and chargers at the sides."""
    bare = benchmark_warehouse(3, 10, 9, 2, 1)
    rows, columns = range(2, bare.height - 2), range(8, bare.width - 8, 3)
    pickups = [
        (row, col)
        for row in range(1, bare.height - 2)
        for col in columns
        if bare.is_open((row, col)) and bare.rows[row + 1][col] == WALL
    ]
    dropoffs = [(row, col) for row in rows[::2] for col in (3, bare.width - 4)]
    chargers = [(row, col) for row in rows[::4] for col in (1, bare.width - 2)]
    return bare.with_tiles(pickups, dropoffs, chargers[:16])


LAYOUT = warehouse()


def fleet_of(layout: Layout, robots: int, battery: int, **settings: Any) -> FleetEnv:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        orders = OrderQueue(2 * robots, DUE)
        return FleetEnv(layout, robots, orders=orders, battery=battery, dispatch=False, **settings)


def run(assignment: str, seed: int, steps: int, planner: str = PLANNER) -> FleetMeasures:
    env = fleet_of(LAYOUT, ROBOTS, 400, max_steps=steps)
    agent = make_fleet_agent(planner, assignment, seed, LAYOUT)
    env.reset(seed=seed)
    agent.reset()
    is_over = False
    while not is_over:
        *_, terminated, truncated, _ = env.step(agent.act(env))
        is_over = bool((terminated | truncated).all())
    return env.measures


def words(found: Interval | None, digits: int = 0) -> str:
    assert found is not None
    return f"{found.estimate:,.{digits}f} ({found.low:,.{digits}f} to {found.high:,.{digits}f})"


def test_assignments_of_an_overloaded_fleet(measured) -> None:
    runs = {name: [run(name, seed, STEPS) for seed in SEEDS] for name in ASSIGNMENTS}
    hourly = {name: np.array([each.per_hour for each in found]) for name, found in runs.items()}
    on_time = {
        name: np.array([100 * each.on_time for each in found]) for name, found in runs.items()
    }
    for name, found in runs.items():
        late = max(each.worst_lateness for each in found)
        flat = sum(each.stranded for each in found)
        measured(
            f"assignment {name}, {ROBOTS} robots",
            f"{words(mean_interval(hourly[name]))} deliveries per hour, "
            f"{words(mean_interval(on_time[name]), 1)}% on time, at most {late:.0f} steps late, "
            f"{flat} robots with a flat battery in {len(SEEDS)} shifts",
        )
    more = mean_interval(on_time["urgent"] - on_time["nearest"])
    share = mean_interval(100 * hourly["urgent"] / hourly["hungarian"])
    measured(
        "urgent compared with nearest and hungarian",
        f"{words(more, 1)} percentage points more on time than nearest, with {words(share, 1)}% "
        "of the deliveries of hungarian",
    )
    assert more is not None
    assert share is not None
    assert more.low >= 10
    assert share.low >= 95


SHIFTS = [
    # Except for the low rate of 0.06, there are more orders than the fleet can carry out.
    (find_layout(Path(DEPOT)), 2, 0.15, 150, 20),
    (find_layout(Path(DEPOT)), 4, 0.2, 150, 20),
    (find_layout(Path(DEPOT)), 8, 0.3, 200, 20),
    (find_layout(Path(DEPOT)), 8, 0.06, 1000, 5),
    (LAYOUT, 96, 1.8, 200, 3),
]


@pytest.mark.parametrize(("layout", "robots", "rate", "steps", "shifts"), SHIFTS)
def test_share_of_what_was_possible(layout, robots, rate, steps, shifts, measured) -> None:
    """Batteries are so large that they do not run out, because the optimum ignores them."""
    proved, seconds, most = 0, list[float](), np.zeros(2)
    made = {name: np.zeros(2) for name in ASSIGNMENTS}
    for seed in range(shifts):
        for name, counts in made.items():
            settings: Any = {"max_steps": steps, "battery": 100 * steps, "dispatch": False}
            env = FleetEnv(layout, robots, orders=OrderStream(rate, DUE), **settings)
            agent = make_fleet_agent("pibt", name, seed, layout)
            shift = record_fleet_episode(env, agent, seed=seed)
            late = [order.delivered > order.due for order in shift.orders if order.delivered]
            counts += len(late), late.count(False)
        start = time.process_time()
        found = most_deliveries(shift), most_deliveries(shift, on_time=True)
        seconds.append((time.process_time() - start) / 2)
        most += [each.most for each in found]
        proved += sum(each.is_exact for each in found)
    shares = {name: 100 * counts / most for name, counts in made.items()}
    measured(
        f"share of the possible deliveries, {robots} robots, {rate} orders per step, {steps} steps",
        ", ".join(f"{name} {every:.1f}%" for name, (every, _) in shares.items())
        + "; on time "
        + ", ".join(f"{name} {on_time:.1f}%" for name, (_, on_time) in shares.items())
        + f"; {most[0] / shifts:.1f} deliveries were possible, {most[1] / shifts:.1f} on time; "
        f"{proved} of {2 * shifts} bounds are proved optima; a bound takes "
        f"{np.median(seconds):.1f} s, at most {max(seconds):.1f} s",
    )
    assert all((share <= 100).all() for share in shares.values())
