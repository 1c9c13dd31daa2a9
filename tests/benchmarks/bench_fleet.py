"""Robot-steps per second of fleets and of POGEMA, and long runs.

POGEMA runs with the Python in the environment variable ``POGEMA_PYTHON``, by default with this one.
Times are the best of several rounds, in wall-clock time and in CPU time.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import DROP, EAST, NORTH, PICK, SOUTH, WAIT, WEST, big_warehouse
from helpers.timing import resident

from warehouse_core import FleetEnv, Layout
from warehouse_core.compiled import IS_COMPILED
from warehouse_core.fleet import FleetBatch

pytestmark = pytest.mark.filterwarnings("ignore:.*can keep")

LAYOUT = big_warehouse()
ROUNDS, CYCLE = 5, 20
OURS, THEIRS, MAX_STEPS = 200_000, 10_000, 500
"""Robot-steps in a round of our fleet and of POGEMA, and maximum joint steps of our fleet."""

POGEMA_MOVES = np.array([1, 4, 2, 3, 0])
"""POGEMA's numbers for our moves and for waiting."""

BARE = "robots only"
KINDS: dict[str, dict[str, Any]] = {
    BARE: {},
    "with orders and chargers": {"orders": 0.01},
    "with orders, chargers and people": {"orders": 0.01, "people": 0.05},
}
"""Orders per step and people, for each robot."""


def steps_of(robots: int) -> int:
    """Return the number of joint steps in a round."""
    return min(MAX_STEPS, OURS // robots)


def fleet_of(robots: int, kind: str) -> FleetEnv:
    """Return a fleet with batteries that last for all measured steps."""
    settings, steps = dict(KINDS[kind]), steps_of(robots) * (ROUNDS + 3)
    if "orders" in settings:
        settings["orders"] *= robots
    settings["people"] = max(1, round(robots * settings["people"])) if "people" in settings else 0
    fleet = FleetEnv(LAYOUT, robots, max_steps=steps, battery=steps + 1, **settings)
    fleet.reset(seed=1)
    return fleet


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Return the wall-clock time and the CPU time of a call in seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - cpu


@contextmanager
def pogema(fleet: FleetEnv, actions: np.ndarray) -> Iterator[Callable[[int], tuple[float, float]]]:
    """Yield a function that steps POGEMA in the same layout with the same actions."""
    targets = np.random.default_rng(2).permutation(LAYOUT.open_cells)[: len(fleet.cells)]
    bare = LAYOUT.with_stations(None, None)
    given = {
        "map": [row.replace("C", ".") for row in bare.rows],
        "starts": fleet.cells,
        "targets": [divmod(cell, LAYOUT.width) for cell in targets.tolist()],
        "actions": POGEMA_MOVES[actions].tolist(),
    }
    python = os.environ.get("POGEMA_PYTHON", sys.executable)
    command = [python, str(Path(__file__).with_name("pogema_worker.py"))]
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    with subprocess.Popen(command, env=environment, **pipes) as worker:
        print(json.dumps(given), file=worker.stdin, flush=True)

        def step(steps: int) -> tuple[float, float]:
            print(steps, file=worker.stdin, flush=True)
            wall, cpu = map(float, worker.stdout.readline().split())
            return wall, cpu

        yield step
        worker.stdin.close()


LEAST = {1: 0.5, 4: 1.0, 10: 1.0, 1_000: 15.0}
"""Least ratios to POGEMA's class by number of robots. Up to 10 robots they need Numba."""


@pytest.mark.parametrize("robots", [1, 4, 10, 100, 1_000, 10_000])
def test_robot_steps_a_second(robots: int, measured) -> None:
    stream = np.random.default_rng(0)
    actions = stream.integers(0, WAIT + 1, (CYCLE, robots))
    busy = stream.integers(0, 7, (CYCLE, robots))
    fleets = {kind: fleet_of(robots, kind) for kind in KINDS}
    ours, theirs = steps_of(robots), max(1, THEIRS // robots)

    def step(kind: str) -> None:
        fleet, chosen = fleets[kind], actions if kind == BARE else busy
        for number in range(ours):
            fleet.step(chosen[number % CYCLE])

    times: dict[str, list[tuple[float, float]]] = {kind: [] for kind in [*KINDS, "POGEMA"]}
    with pogema(fleets[BARE], actions) as step_theirs:
        step_theirs(1)
        for kind in KINDS:
            step(kind)
        for _ in range(ROUNDS):
            for kind in KINDS:
                times[kind].append(timed(lambda kind=kind: step(kind)))
            times["POGEMA"].append(step_theirs(theirs))
    rates = {}
    for kind, found in times.items():
        steps = robots * (theirs if kind == "POGEMA" else ours)
        rates[kind] = [steps / min(column) for column in zip(*found, strict=True)]
    words = [f"{kind} {wall:,.0f} ({cpu:,.0f})" for kind, (wall, cpu) in rates.items()]
    wall, cpu = (a / b for a, b in zip(rates[BARE], rates["POGEMA"], strict=True))
    measured(
        f"robot-steps per second, {robots:,} robots",
        f"{'; '.join(words)}; {wall:.2f} ({cpu:.2f}) times POGEMA; in parentheses per second of "
        "CPU time",
    )
    assert cpu >= LEAST.get(robots, 0) or (robots <= 10 and not IS_COMPILED)


def rate_of_fleets(fleets: int, robots: int, orders: float | None = None) -> float:
    """Return the robot-steps of many fleets together per second of CPU time."""
    batch = FleetBatch(fleets, robots=robots, max_steps=1000, battery=1000, orders=orders)
    batch.reset(seed=1)
    actions = np.random.default_rng(0).integers(0, 7, (CYCLE, batch.num_envs))
    for each in actions:
        batch.step(each)
    return batch.num_envs * CYCLE / timed(lambda: [batch.step(each) for each in actions])[1]


@pytest.mark.parametrize("fleets", [256, 2048])
def test_orders_of_many_fleets(fleets: int, measured) -> None:
    """Fleets of four robots get an order every 20 steps."""
    rates = {None: 0.0, 0.05: 0.0}
    for _ in range(ROUNDS):
        for orders in rates:
            rates[orders] = max(rates[orders], rate_of_fleets(fleets, 4, orders))
    bare, busy = rates.values()
    measured(
        f"robot-steps of {fleets:,} fleets of 4 robots per second of CPU time",
        f"{busy:,.0f} with orders, {bare:,.0f} without; ratio {busy / bare:.2f}",
    )
    assert busy >= 0.2 * bare


def test_lone_robots_in_thousands_of_layouts(measured) -> None:
    """Fleets of one robot move as arrays, so that a robot takes less time than in fleets of two."""
    fleets, rates = 4096, {1: 0.0, 2: 0.0}
    for _ in range(ROUNDS):
        for robots in rates:
            rates[robots] = max(rates[robots], rate_of_fleets(fleets, robots))
    words = ", ".join(f"{rate:,.0f} with {robots}" for robots, rate in rates.items())
    ratio = rates[1] / rates[2]
    measured(
        f"robot-steps of {fleets:,} fleets per second of CPU time, by robots in a fleet",
        f"{words}; ratio {ratio:.2f}",
    )
    assert ratio >= 1.3


@pytest.mark.parametrize("orders", [None, 100.0])
def test_a_reset_of_ten_thousand_robots(orders: float | None, measured) -> None:
    fleet = FleetEnv(LAYOUT, 10_000, orders=orders, max_steps=1000, battery=1000)
    wall, cpu = (min(each) for each in zip(*(timed(fleet.reset) for _ in range(9)), strict=True))
    name = f"reset of 10,000 robots{' with 100,000 orders' if orders else ''}"
    measured(name, f"{wall:.3f} s, {cpu:.3f} s of CPU time")
    assert cpu < 0.1


def towards_goals(arrays: Any, mask: np.ndarray, stream: np.random.Generator) -> np.ndarray:
    """Return actions that pick, deliver or move towards the goal, with some random moves."""
    goals = np.where(arrays["pickup_pos"] >= 0, arrays["pickup_pos"], arrays["dropoff_pos"])
    down, right = (goals - arrays["robot_pos"]).T
    along = np.where(right > 0, EAST, WEST)
    across = np.where(down > 0, SOUTH, NORTH)
    is_across = (right == 0) | ((down != 0) & (stream.random(len(down)) < 0.5))
    moves = np.where(is_across, across, along)
    is_random = (goals[:, 0] < 0) | (stream.random(len(down)) < 0.3)
    moves = np.where(is_random, stream.integers(0, 5, len(down)), moves)
    return np.where(mask[:, PICK], PICK, np.where(mask[:, DROP], DROP, moves))


def test_memory_of_ten_million_robot_steps(measured) -> None:
    """The fleet has orders, chargers and people, and a new episode begins every thousand steps."""
    layout, robots, steps = Layout(LAYOUT.rows[:40]), 1000, 10_000
    fleet = FleetEnv(layout, robots, orders=5.0, people=50, battery=2000, max_steps=1000)
    stream, sizes, delivered = np.random.default_rng(1), [], 0
    for episode in range(steps // 1000):
        arrays, info = fleet.reset(seed=episode)
        for _ in range(1000):
            actions = towards_goals(arrays, info["action_mask"], stream)
            arrays, _, _, _, info = fleet.step(actions)
        delivered += fleet.measures.delivered
        sizes.append(resident())
    measured(
        f"memory during {robots * steps:,} robot-steps with orders, chargers and people",
        f"{sizes[1] / 2**20:.1f} MB after 20% of the steps, {sizes[-1] / 2**20:.1f} MB at the end; "
        f"{delivered:,} deliveries",
    )
    assert sizes[-1] - sizes[1] <= 8 * 2**20
