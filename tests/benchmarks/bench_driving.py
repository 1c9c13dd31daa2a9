"""Robots that drive through plans: makespan, joules and hits, speed and memory.

``WAREHOUSE_PLANS`` is the number of plans of each planner and number of robots, or of random plans.

The bound of robots alone on the floor drives along straight lines between the middles of cells, and
round each corner on a quarter circle from edge to edge of its cell. On the circle it has the
highest constant speed whose centripetal acceleration is that of the robot. On the lines it
accelerates and brakes as hard as the robot can, up to the top speed. It stops only where a path
turns back or ends. Robots may be faster where they cut a corner along another curve.

Random plans have noise, slippery floors, stops and failures. The paths of all robots are checked by
their geometry: distances between discs, and to walls. A plan of each hundred has 30 to 200 robots,
the others 2 to 12, on open floors, among walls, in narrow aisles with bays, and among shelves.
"""

import itertools
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
from helpers.driving import resolved
from helpers.driving_validator import Place, ways_of
from helpers.fleet_truth import big_warehouse
from helpers.timing import resident
from scipy.spatial import cKDTree

from agents.mapf.execution import Execution, drive_steps, drive_through
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.lifelong import run_lifelong
from agents.mapf.problem import Problem
from agents.registry import PLANNERS, make_fleet_agent, make_planner
from warehouse_core import Cell, FleetEnv, Layout, Outcome
from warehouse_core.fleet import Battery, FleetMeasures
from warehouse_core.orders.order import Order
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.generators import kiva_warehouse, shelf_layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

PLANS, STEPS = int(os.environ.get("WAREHOUSE_PLANS", "1")), 100
MAX_RATIO = {32: 0.8, 100: 0.9, 192: 0.9}
"""Makespan driven through over that of joint steps, by number of robots."""

MAX_JOULES = 0.8
MEASURED = 2
"""Plans of which the joint steps are executed too; of the others they take as long a step."""

LAYOUT, STARTS, GOALS = kiva_warehouse()
ONCE = "lacam"
"""A planner of robots that go to their goals once."""

SPELL = 10
"""Simulated seconds whose duration is measured."""


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
    """A plan driven through, and in joint steps if they were executed."""

    steps: int
    driven: Execution
    stepped: Execution | None


def compare(name: str, robots: int, seed: int) -> Comparison:
    """Execute a plan in both ways; the second only of the first plans."""
    plan = plan_of(name, robots, seed)
    stepped = drive_steps(LAYOUT, plan) if seed < MEASURED else None
    has_moves = (np.diff(plan, axis=0) != 0).any(axis=1)
    steps = int(np.flatnonzero(has_moves)[-1]) + 1
    return Comparison(steps, drive_through(LAYOUT, plan), stepped)


def ratios_of(found: list[Comparison]) -> tuple[float, float, int]:
    """Return the largest ratio of makespans and of joules, and the number of hits."""
    step = max(each.stepped.seconds / each.steps for each in found if each.stepped)
    return (
        max(each.driven.seconds / (step * each.steps) for each in found),
        max(each.driven.joules / each.stepped.joules for each in found if each.stepped),
        sum(each.driven.hits for each in found),
    )


@pytest.mark.parametrize("robots", MAX_RATIO)
@pytest.mark.parametrize("name", [*PLANNERS, ONCE])
def test_plans_are_driven_through_faster_than_in_joint_steps(
    name: str, robots: int, measured
) -> None:
    found = [compare(name, robots, seed) for seed in range(PLANS)]
    makespan, joules, hits = ratios_of(found)
    mean = np.mean([each.driven.seconds / each.steps for each in found])
    measured(
        f"driven through, {name}, {robots} robots, {PLANS} plans",
        f"{mean:.2f} s a joint step; makespan at most {makespan:.3f} of joint steps; joules at "
        f"most {joules:.3f} in {min(PLANS, MEASURED)} plans; {hits} hits",
    )
    assert hits == 0
    assert joules <= MAX_JOULES
    assert makespan <= MAX_RATIO[robots]


class Crowd:
    """Robots on a large map that go straight on for a few cells at random, and turn."""

    def __init__(self, robots: int) -> None:
        self.layout, self._stream = big_warehouse(), np.random.default_rng(robots)
        starts = self._stream.permutation(self.layout.open_cells)[:robots].tolist()
        self.motion, self._loaded = DrivingMotion(), [False] * robots
        self.motion.reset(self.layout, [divmod(cell, self.layout.width) for cell in starts], 0)
        self._actions = np.zeros(robots, np.intp)

    def drive(self, seconds: int) -> None:
        """Drive on."""
        robots = len(self._actions)
        for _ in range(seconds):
            turns = self._stream.random(robots) < 0.3
            drawn = self._stream.integers(0, WAIT, robots)
            self._actions = np.where(turns, drawn, self._actions)
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
        "simulated time over time taken, 1,000 bodies driven through",
        f"{wall:.1f} by the clock, {cpu:.1f} by CPU time, with {os.getloadavg()[0]:.1f} processes "
        "running or waiting",
    )
    assert cpu >= 5


def test_memory_is_flat_over_a_thousand_seconds(measured) -> None:
    crowd = Crowd(100)
    crowd.drive(100)
    before = resident()
    crowd.drive(900)
    grown = resident() - before
    measured("memory gained by 100 bodies in 900 simulated seconds", f"{grown / 1e6:.1f} MB")
    assert grown < 1e6


ROBOTS = 32
ALONE_SPECS = {
    "default robots": RobotSpec(),
    "fast robots": RobotSpec(top_speed=2.0, acceleration=1.0),
    "slow robots": RobotSpec(top_speed=1.0, acceleration=0.5),
}
MAX_ALONE = 1.06
ALONE_SPELL, MOVES = 5.0, 1e-5
"""Seconds of a spell, and metres in a substep that are a move."""


def bound(way: list[Place], spec: RobotSpec) -> float:
    """Return the seconds that the fastest robot needs for the cells of a way."""
    rate, half = spec.acceleration, spec.cell_size / 2
    corner_speed = min(spec.top_speed, math.sqrt(rate * half))
    runs = [
        (move, spec.cell_size * len(list(same)))
        for move, same in groupby((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(way))
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
    """Return the least seconds over a length in metres, between two speeds in m/s."""
    rate = spec.acceleration
    peak = min(spec.top_speed, math.sqrt(rate * length + (before**2 + after**2) / 2))
    at_peak = length - (2 * peak**2 - before**2 - after**2) / (2 * rate)
    return (2 * peak - before - after) / rate + max(at_peak, 0.0) / peak


def arrivals(ways: list[list[Place]], spec: RobotSpec) -> np.ndarray:
    """Return the seconds in which each robot drives its way, on an empty floor of its own."""
    height, steps = LAYOUT.height, max(map(len, ways))
    motion = DrivingMotion(spec, path_every=1)
    joint = [
        [(robot * height + row, col) for robot, (row, col) in enumerate(cells)]
        for cells in zip(*([*way, *[way[-1]] * (steps - len(way))] for way in ways), strict=True)
    ]
    motion.reset(Layout(["." * LAYOUT.width] * (height * len(ways))), joint[0], 0)
    for cells in joint[1:]:
        motion.extend(cells)
    found, now = np.zeros(len(ways)), 0.0
    while not all(motion.ways().at_rest):
        for robot, outcome in enumerate(motion.drive(ALONE_SPELL)):
            clock, moved = outcome.path[1:, 0], np.abs(np.diff(outcome.path[:, 1:3], axis=0))
            if len(times := clock[moved.max(axis=1) > MOVES]):
                found[robot] = now + times[-1]
        now += ALONE_SPELL
    return found


@pytest.mark.parametrize("planner", ["pibt", "windowed", "pibt-lanes"])
@pytest.mark.parametrize("kind", ALONE_SPECS)
def test_robots_alone_are_nearly_as_fast_as_force_and_speed_allow(
    planner: str, kind: str, measured
) -> None:
    mover = make_planner(planner, 0, LAYOUT, ROBOTS)
    run = run_lifelong(Graph(LAYOUT), mover, ROBOTS, STEPS, 0, STARTS, GOALS)
    ways = ways_of([LAYOUT.cells(cells) for cells in run.cells])
    least = np.array([bound(way, ALONE_SPECS[kind]) for way in ways])
    driven = arrivals(ways, ALONE_SPECS[kind])
    ratios = driven[least > 0] / least[least > 0]
    measured(
        f"{ROBOTS} ways of {planner} driven alone, {kind}",
        f"{driven.max() / least.max():.3f} of the bound by the last arrival, "
        f"{driven.sum() / least.sum():.3f} by the mean of all, at most {ratios.max():.3f}",
    )
    assert ratios.max() <= MAX_ALONE


LAYOUTS = {
    32: shelf_layout(5, 6, 4, 2, 2, pickups=16, dropoffs=8),
    100: shelf_layout(8, 10, 4, 2, 2, pickups=48, dropoffs=24),
}
"""By number of robots, with 14 cells or more and a quarter of a dropoff for each."""

ORDERS_OF_A_ROBOT, MAX_STEPS, LATE = 2, 1200, 100_000
STOP_SECONDS = 60.0
NOISY = Disturbances(actuation_noise=0.05, stops=(Stop(0, 20.0, STOP_SECONDS),))
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
    share = (noisy.seconds - STOP_SECONDS) / nominal.seconds
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


NOISE, SECONDS, WITHIN = 0.05, 60.0, (10.0, 60.0)
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


RANDOM_PLANS = int(os.environ.get("WAREHOUSE_PLANS", "100"))
FAST = RobotSpec.fast()
FAULT_SPECS = (
    RobotSpec(),
    FAST,
    replace(FAST, turn_seconds=0.5),
    replace(FAST, radius=0.2),
    replace(FAST, drive="differential"),
)
MANY = 100
"""One plan of so many has many robots."""

FAULT_SPELL, PATIENCE, MAX_SPELLS = 5.0, 15, 700
"""Seconds of a spell, spells without a move after which nobody will move, and most spells."""

SLACK, STILL = 1e-5, 1e-4


class Result(NamedTuple):
    """What is wrong with a plan, and how many robots it has, and how many of them failed."""

    faults: list[str]
    robots: int
    failed: int


def floor_of(stream: random.Random, is_large: bool) -> Layout:
    """Return a random floor."""
    if is_large:
        size = 4, stream.randint(4, 6), stream.randint(4, 6)
        return shelf_layout(*size, aisle=stream.choice([1, 2]), seed=stream.randrange(100))
    kind, width = stream.choice(["open", "walls", "narrow", "shelves"]), stream.randint(4, 12)

    def row(tiles: str) -> str:
        return "".join(stream.choice(tiles) for _ in range(width))

    if kind == "open":
        return Layout(["." * width] * stream.randint(2, 6))
    if kind == "walls":
        return Layout([*(row("....#") for _ in range(stream.randint(2, 6))), "." * width])
    if kind == "narrow":
        return Layout([row("##."), "." * width, row("##."), stream.choice(".#") * width])
    size = stream.randint(1, 3), stream.randint(2, 3), stream.randint(2, 4)
    return shelf_layout(*size, aisle=1, pickups=2, dropoffs=2, seed=stream.randrange(100))


def disturbances_of(stream: random.Random, cells: Sequence[Cell], robots: int) -> Disturbances:
    """Return random disturbances, of which some may be missing."""
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
        Stop(stream.randrange(robots), stream.uniform(0, 15), stream.choice(seconds))
        for _ in range(stream.choice([0, 0, 1, 2, 3]))
    )
    return Disturbances(**found)


class Run:
    """A plan, given at once or while robots drive, and what they did."""

    def __init__(self, seed: int) -> None:
        self._stream = stream = random.Random(seed)
        is_large = seed % MANY == MANY - 1
        self._layout = floor_of(stream, is_large)
        cells = [divmod(int(cell), self._layout.width) for cell in self._layout.open_cells]
        most = int(0.7 * len(cells))
        few, many = (2, max(2, min(12, most))), (30, max(30, min(200, most)))
        self._robots = min(stream.randint(*(many if is_large else few)), len(cells))
        self._starts = stream.sample(cells, self._robots)
        self._spec = stream.choice(FAULT_SPECS)
        disturbances = disturbances_of(stream, cells, self._robots)
        self._motion = DrivingMotion(self._spec, disturbances, path_every=1, switches=True)
        self._motion.reset(self._layout, self._starts, stream.randrange(1000))
        self._loaded = [stream.random() < 0.5 for _ in self._starts]
        self._ways = [stream.randrange(WAIT) for _ in self._starts]
        self._paths: list[np.ndarray] = []
        self._hits, self._now = 0, 0.0

    def result(self) -> Result:
        """Carry out the plan, and return what is wrong with it."""
        faults = [*self._drive(), *self._geometry()]
        failed = sum(self._motion.ways().failed)
        self._motion.close()
        return Result(faults, self._robots, failed)

    def _drive(self) -> list[str]:
        stream, fails = self._stream, self._stream.choice([0, 0, 1, 2, 3])
        times, steps = sorted(stream.uniform(0, 20) for _ in range(fails)), stream.randint(3, 20)
        if stream.random() < 0.5:
            plan = resolved(self._layout, self._starts, [self._actions() for _ in range(steps)])
            for cells in plan[1:]:
                self._motion.extend(cells)
            self._move([WAIT] * self._robots)
            for at in times:
                if at > self._now:
                    self._add(self._motion.drive(at - self._now))
                self._motion.fail(stream.randrange(self._robots))
        else:
            for _ in range(steps):
                while times and times[0] <= 1.5 * self._now:
                    times.pop(0)
                    self._motion.fail(stream.randrange(self._robots))
                self._move(self._actions())
        return self._come_to_rest()

    def _come_to_rest(self) -> list[str]:
        """Drive until all robots that have not failed are at rest at different open cells."""
        still, before = 0, self._paths[-1][-1]
        for _ in range(MAX_SPELLS):
            ways = self._motion.ways()
            if all(map(max, ways.at_rest, ways.failed)):
                break
            self._add(self._motion.drive(FAULT_SPELL))
            now = self._paths[-1][-1]
            still = still + 1 if np.abs(now - before).max() < STILL else 0
            if still == PATIENCE:
                return ["nobody moves any more"]
            before = now
        else:
            return ["robots do not come to rest"]
        live = [end for end, fails in zip(ways.ends, ways.failed, strict=True) if not fails]
        if len({*live, *ways.closed}) != len(live) + len(ways.closed):
            return ["two robots rest at one cell"]
        return []

    def _geometry(self) -> list[str]:
        """Compare all positions with each other and with the walls."""
        rows = np.concatenate(self._paths) / self._spec.cell_size
        rows = rows[np.append(True, np.abs(np.diff(rows, axis=0)).max(axis=(1, 2)) > 0)]
        apart = min(cKDTree(row).query(row, k=2)[0][:, 1].min() for row in rows)
        faults = [f"{self._hits} hits"] if self._hits else []
        if apart < 2 * self._spec.radius * (1 - SLACK):
            faults.append(f"robots are {apart:.4f} apart")
        if (gap := self._to_walls(rows)) < self._spec.radius * (1 - SLACK):
            faults.append(f"a robot is {gap:.4f} from a wall")
        return faults

    def _to_walls(self, rows: np.ndarray) -> float:
        """Return the least distance of the middle of a robot from a wall."""
        layout, cells = self._layout, np.floor(rows[..., ::-1]).astype(int)
        size = layout.height, layout.width
        walls = np.ones((size[0] + 2, size[1] + 2), np.bool_)
        for row, col in itertools.product(*map(range, size)):
            walls[row + 1, col + 1] = not layout.is_open((row, col))
        least = math.inf
        for down, right in itertools.product((-1, 0, 1), repeat=2):
            row, col = cells[..., 0] + down, cells[..., 1] + right
            is_wall = walls[np.clip(row + 1, 0, size[0] + 1), np.clip(col + 1, 0, size[1] + 1)]
            beside, above = (
                np.maximum(np.maximum(low - at, at - low - 1), 0)
                for low, at in ((col, rows[..., 0]), (row, rows[..., 1]))
            )
            least = min(least, np.hypot(beside, above)[is_wall].min(initial=math.inf))
        return least

    def _actions(self) -> list[int]:
        """Return random actions of robots that mostly go straight on."""
        stream = self._stream
        for robot in range(self._robots):
            if stream.random() < 0.3:
                self._ways[robot] = stream.randrange(WAIT)
        return [way if stream.random() < 0.9 else WAIT for way in self._ways]

    def _move(self, actions: Sequence[int]) -> None:
        moves = [DISPLACEMENTS[action] for action in actions]
        self._add(self._motion.advance(moves, self._loaded))

    def _add(self, outcomes: Sequence[Outcome]) -> None:
        self._hits += sum(len(outcome.contacts) for outcome in outcomes)
        self._paths.append(np.stack([outcome.path[1:, 1:3] for outcome in outcomes], axis=1))
        self._now += outcomes[0].seconds


def test_nobody_is_hit_whatever_fails_or_slips(measured) -> None:
    results = [Run(seed).result() for seed in range(RANDOM_PLANS)]
    wrong = {seed: each.faults for seed, each in enumerate(results) if each.faults}
    robots, failed = (sum(each[place] for each in results) for place in (1, 2))
    measured(
        f"driving with disturbances, {RANDOM_PLANS:,} random plans",
        f"{len(wrong)} with a hit, an overlap or robots that do not come to rest; "
        f"{robots:,} robots, of which {failed:,} failed",
    )
    assert not wrong
