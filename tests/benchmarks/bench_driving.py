"""Robots that drive through plans: makespan, energy and hits, speed and memory.

``WAREHOUSE_PLANS`` is the number of plans for each planner and number of robots, or the number of
random plans.

The bound for robots that are alone in a layout is the time of an ideal robot. It drives along
straight lines between the centres of cells, and around each corner on a quarter circle from edge to
edge of the cell. On the circle it has the highest constant speed whose centripetal acceleration
does not exceed the acceleration of the robot. On the lines it accelerates and brakes as hard as the
robot can, up to the top speed. It stops only where a path reverses or ends. Robots may be faster
where they cut a corner along another curve.

Random plans have noise, slippery cells, stops and failures. One plan in a hundred has 30 to 200
robots, and the others have 2 to 12. Their layouts are open, have random walls, narrow aisles or
shelves.
"""

import math
import os
import random
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.driving import Failures, resolved
from helpers.driving_validator import Place, routes_of
from helpers.fleet_truth import big_warehouse
from helpers.timing import resident

from agents.mapf.execution import Execution, drive_steps, drive_through
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.lifelong import run_lifelong
from agents.mapf.problem import Problem
from agents.registry import PLANNERS, make_planner
from warehouse_core import Cell, Layout
from warehouse_core.wording import counted
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.generators import kiva_warehouse, shelf_layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

PLANS, STEPS = int(os.environ.get("WAREHOUSE_PLANS", "1")), 100
MAX_RATIO = {32: 0.8, 100: 0.9, 192: 0.9}
"""Maximum ratio of the makespan of driving through to the makespan of joint steps, by robots."""

MAX_JOULES = 0.8
MEASURED = 2
"""Number of plans that are also executed in joint steps.

For the other plans, joint steps are assumed to take as long as in these plans.
"""

LAYOUT, STARTS, GOALS = kiva_warehouse()
ONCE = "lacam"
"""A planner for robots that have one goal each."""

SPELL = 10
"""Number of simulated seconds whose duration is measured."""


def plan_of(name: str, robots: int, seed: int) -> np.ndarray:
    """Return a plan on the Kiva-like map, ``[T + 1, R]``."""
    graph = Graph(LAYOUT)
    if name == ONCE:
        stream = np.random.default_rng(seed)
        starts, goals = (stream.permutation(each)[:robots].tolist() for each in (STARTS, GOALS))
        return lacam(Problem(graph, starts, goals), 60.0, seed).cells
    planner = make_planner(name, seed, LAYOUT, robots)
    return run_lifelong(graph, planner, robots, STEPS, seed, STARTS, GOALS).cells


class Comparison(NamedTuple):
    """The executions of a plan by driving through and, for some plans, in joint steps."""

    steps: int
    driven: Execution
    stepped: Execution | None


def compare(name: str, robots: int, seed: int) -> Comparison:
    """Execute a plan by driving through and, if it is one of the first, in joint steps."""
    plan = plan_of(name, robots, seed)
    stepped = drive_steps(LAYOUT, plan) if seed < MEASURED else None
    has_moves = (np.diff(plan, axis=0) != 0).any(axis=1)
    steps = int(np.flatnonzero(has_moves)[-1]) + 1
    return Comparison(steps, drive_through(LAYOUT, plan), stepped)


def ratios_of(found: list[Comparison]) -> tuple[float, float, int]:
    """Return the largest ratio of makespans, the largest ratio of energies, and the hits."""
    step = max(each.stepped.seconds / each.steps for each in found if each.stepped)
    return (
        max(each.driven.seconds / (step * each.steps) for each in found),
        max(each.driven.joules / each.stepped.joules for each in found if each.stepped),
        sum(each.driven.hits for each in found),
    )


@pytest.mark.parametrize("robots", MAX_RATIO)
@pytest.mark.parametrize("name", [*PLANNERS, ONCE])
def test_plans_are_driven_through_faster_than_in_joint_steps(name, robots, measured) -> None:
    found = [compare(name, robots, seed) for seed in range(PLANS)]
    makespan, joules, hits = ratios_of(found)
    mean = np.mean([each.driven.seconds / each.steps for each in found])
    measured(
        f"driving through the plans of {name}, {robots} robots, {counted(PLANS, 'plan')}",
        f"{mean:.2f} s per joint step; compared with stops in every cell, makespan at most "
        f"{makespan:.3f}, energy at most {joules:.3f} in {counted(min(PLANS, MEASURED), 'plan')}; "
        f"{hits} hits",
    )
    assert hits == 0
    assert joules <= MAX_JOULES
    assert makespan <= MAX_RATIO[robots]


class Crowd:
    """Robots in a large layout that drive straight on for a random distance and then turn."""

    def __init__(self, robots: int) -> None:
        self.layout, self._stream = big_warehouse(), np.random.default_rng(robots)
        starts = self._stream.permutation(self.layout.open_cells)[:robots].tolist()
        self.motion, self._loaded = DrivingMotion(), [False] * robots
        self.motion.reset(self.layout, [divmod(cell, self.layout.width) for cell in starts], 0)
        self._actions = np.zeros(robots, np.intp)

    def drive(self, seconds: int) -> None:
        """Advance the simulation by some seconds, and check that nothing is hit."""
        robots = len(self._actions)
        for _ in range(seconds):
            turns = self._stream.random(robots) < 0.3
            others = self._stream.integers(0, WAIT, robots)
            self._actions = np.where(turns, others, self._actions)
            moves = [DISPLACEMENTS[action] for action in self._actions.tolist()]
            assert not any(each.contacts for each in self.motion.advance(moves, self._loaded))


def test_a_thousand_bodies_drive_faster_than_real_time(measured) -> None:
    crowd, rounds = Crowd(1000), []
    for _ in range(4):
        since, used = time.perf_counter(), time.process_time()
        crowd.drive(SPELL)
        rounds.append((time.perf_counter() - since, time.process_time() - used))
    wall, cpu = (SPELL / min(column) for column in zip(*rounds, strict=True))
    measured(
        "simulated seconds per second, 1,000 robots driving through",
        f"{wall:.1f} in wall-clock time, {cpu:.1f} in CPU time, with {os.getloadavg()[0]:.1f} "
        "processes running or waiting",
    )
    assert cpu >= 5


def test_memory_is_flat_over_a_thousand_seconds(measured) -> None:
    crowd = Crowd(100)
    crowd.drive(100)
    before = resident()
    crowd.drive(900)
    grown = resident() - before
    measured("memory growth with 100 robots in 900 simulated seconds", f"{grown / 1e6:.1f} MB")
    assert grown < 1e6


ROBOTS = 32
ALONE_SPECS = {
    "default robots": RobotSpec(),
    "fast robots": RobotSpec(top_speed=2.0, acceleration=1.0),
    "slow robots": RobotSpec(top_speed=1.0, acceleration=0.5),
}
MAX_ALONE = 1.06
ALONE_SPELL, MOVES = 5.0, 1e-5
"""Seconds of a spell, and minimum metres in a substep that count as a move."""


def bound(path: list[Place], spec: RobotSpec) -> float:
    """Return the seconds that an ideal robot needs to drive along the cells of a path."""
    rate, half = spec.acceleration, spec.cell_size / 2
    corner_speed = min(spec.top_speed, math.sqrt(rate * half))
    runs = [
        (move, spec.cell_size * len(list(same)))
        for move, same in groupby((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(path))
    ]
    seconds, before, cut = 0.0, 0.0, 0.0
    for (move, length), (after, _) in pairwise([*runs, ((0, 0), 0.0)]):
        is_corner = any(after) and (move[0] + after[0], move[1] + after[1]) != (0, 0)
        speed, left = (corner_speed, half) if is_corner else (0.0, 0.0)
        seconds += seconds_on_line(length - cut - left, before, speed, spec)
        seconds += math.pi / 2 * half / corner_speed if is_corner else 0.0
        before, cut = speed, left
    return seconds


def seconds_on_line(length: float, before: float, after: float, spec: RobotSpec) -> float:
    """Return the minimum time in s for a length in m, given the speeds in m/s at its ends."""
    rate = spec.acceleration
    peak = min(spec.top_speed, math.sqrt(rate * length + (before**2 + after**2) / 2))
    at_peak = length - (2 * peak**2 - before**2 - after**2) / (2 * rate)
    return (2 * peak - before - after) / rate + max(at_peak, 0.0) / peak


def arrivals(paths: list[list[Place]], spec: RobotSpec) -> np.ndarray:
    """Return the seconds that each robot takes for its path, in an empty layout of its own."""
    height, steps = LAYOUT.height, max(map(len, paths))
    motion = DrivingMotion(spec, path_every=1)
    joint = [
        [(robot * height + row, col) for robot, (row, col) in enumerate(cells)]
        for cells in zip(
            *([*path, *[path[-1]] * (steps - len(path))] for path in paths), strict=True
        )
    ]
    motion.reset(Layout(["." * LAYOUT.width] * (height * len(paths))), joint[0], 0)
    for cells in joint[1:]:
        motion.extend(cells)
    found, now = np.zeros(len(paths)), 0.0
    while not all(motion.routes().at_rest):
        for robot, outcome in enumerate(motion.drive(ALONE_SPELL)):
            clock, moved = outcome.path[1:, 0], np.abs(np.diff(outcome.path[:, 1:3], axis=0))
            if len(times := clock[moved.max(axis=1) > MOVES]):
                found[robot] = now + times[-1]
        now += ALONE_SPELL
    return found


@pytest.mark.parametrize("planner", ["pibt", "windowed", "pibt:guidance=lanes"])
@pytest.mark.parametrize("kind", ALONE_SPECS)
def test_robots_alone_are_nearly_as_fast_as_force_and_speed_allow(planner, kind, measured) -> None:
    mover = make_planner(planner, 0, LAYOUT, ROBOTS)
    run = run_lifelong(Graph(LAYOUT), mover, ROBOTS, STEPS, 0, STARTS, GOALS)
    paths = routes_of([LAYOUT.cells(cells) for cells in run.cells])
    least = np.array([bound(path, ALONE_SPECS[kind]) for path in paths])
    driven = arrivals(paths, ALONE_SPECS[kind])
    ratios = driven[least > 0] / least[least > 0]
    measured(
        f"{ROBOTS} paths of {planner}, each driven alone, {kind}",
        f"time divided by the bound: {driven.max() / least.max():.3f} for the last arrival, "
        f"{driven.sum() / least.sum():.3f} for the mean, at most {ratios.max():.3f}",
    )
    assert ratios.max() <= MAX_ALONE


RANDOM_PLANS = int(os.environ.get("WAREHOUSE_PLANS", "100"))
FAST = RobotSpec.fast()
FAULT_SPECS = (
    RobotSpec(),
    FAST,
    replace(FAST, turn_seconds=0.5),
    replace(FAST, radius=0.2),
    replace(FAST, drive="differential"),
)


def floor_of(stream: random.Random, is_large: bool) -> Layout:
    """Return a random layout, with shelves if it is large."""
    if is_large or stream.random() < 0.3:
        size = (4, 6, 5) if is_large else (2, 3, 3)
        return shelf_layout(*size, aisle=stream.choice([1, 2]), seed=stream.randrange(100))
    width, tiles = stream.randint(4, 12), stream.choice([".", "....#", "##."])
    rows = ["".join(stream.choices(tiles, k=width)) for _ in range(stream.randint(2, 6))]
    return Layout([*rows, "." * width])


def disturbances_of(stream: random.Random, cells: Sequence[Cell], robots: int) -> Disturbances:
    """Return random disturbances; some kinds may be missing."""
    found: dict[str, Any] = {}
    if stream.random() < 0.7:
        found["actuation_noise"] = stream.uniform(0.05, 0.2)
    if stream.random() < 0.5:
        share = stream.choice([0.1, 0.3, 1.0])
        found["slippery"] = frozenset(cell for cell in cells if stream.random() < share)
        found["grip"] = stream.choice([0.03, 0.05, 0.1, 0.3])
    if stream.random() < 0.3:
        found["drag_spread"] = stream.uniform(0.05, 0.5)
    seconds = [1.0, 5.0, 20.0, 60.0, math.inf]
    found["stops"] = tuple(
        Stop(stream.randrange(robots), stream.uniform(2, 15), stream.choice(seconds))
        for _ in range(stream.choice([0, 0, 1, 2, 3]))
    )
    return Disturbances(**found)


def run_of(seed: int) -> Failures:
    """Return robots that have carried out a random plan and have come to rest."""
    stream, is_large = random.Random(seed), seed % 100 == 99
    layout = floor_of(stream, is_large)
    cells = layout.cells(layout.open_cells)
    robots = min(stream.randint(30, 200) if is_large else stream.randint(2, 12), len(cells))
    moves, actions = [WAIT] * robots, []
    for _ in range(stream.randint(3, 20)):  # most robots drive straight on
        moves = [stream.randrange(WAIT) if stream.random() < 0.3 else move for move in moves]
        actions.append([move if stream.random() < 0.9 else WAIT for move in moves])
    plan = resolved(layout, stream.sample(cells, robots), actions)
    loaded = [stream.random() < 0.5 for _ in range(robots)]
    disturbances = disturbances_of(stream, cells, robots)
    crowd = Failures(layout, plan, stream.choice(FAULT_SPECS), loaded, disturbances)
    for _ in range(stream.choice([0, 0, 1, 2, 3])):
        crowd.drive(stream.uniform(0.02, 6.0))
        crowd.motion.fail(stream.randrange(robots))
    crowd.come_to_rest()
    return crowd


def test_nobody_is_hit_whatever_fails_or_slips(measured) -> None:
    robots = failed = 0
    for seed in range(RANDOM_PLANS):
        crowd = run_of(seed)
        crowd.check()
        fails = crowd.motion.routes().failed
        robots, failed = robots + len(fails), failed + sum(fails)
    measured(
        f"driving with disturbances, {RANDOM_PLANS:,} random plans",
        f"no hits, no overlaps, and all robots come to rest; {robots:,} robots, {failed:,} of "
        "which failed",
    )
