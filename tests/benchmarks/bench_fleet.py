"""Robot-steps a second of fleets and of POGEMA, long runs, and fleets that must not freeze.

POGEMA runs in the Python of the environment variable ``POGEMA_PYTHON``, by default this one.
Figures are the best of several rounds, by the clock and by the time of the processor.
``TRUTH_SHARE=0.1`` takes a tenth of the steps of long runs.

A stretch is a number of steps in which nothing is picked or delivered although orders wait. In a
stretch of a fleet among people only those steps count in which something could be, see
``can_work``: where people stand in each other's way, nobody can.
"""

import json
import os
import random
import subprocess
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from heapq import heappop, heappush
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.fleet_truth import (
    DROP,
    EAST,
    NORTH,
    PICK,
    SOUTH,
    WAIT,
    WEST,
    big_warehouse,
    bodies_move_as_the_grid,
    random_lone_steps_equal,
)
from helpers.timing import resident

from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, Layout, LayoutError, OrderQueue, OrderStream, shelf_layout
from warehouse_core.fleet import FleetBatch, People
from warehouse_core.task.rules import CHARGE
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import EMPTY, WALL, Cell

pytestmark = pytest.mark.filterwarnings("ignore:.*can keep")

LAYOUT = big_warehouse()
ROUNDS, CYCLE = 5, 20
OURS, THEIRS, MAX_STEPS = 200_000, 10_000, 500
"""Robot-steps of a round, and joint steps of ours."""

POGEMA_MOVES = np.array([1, 4, 2, 3, 0])
"""POGEMA's number of each of our moves and of waiting."""

KINDS: dict[str, dict[str, Any]] = {
    "alone": {},
    "orders, chargers": {"orders": 0.01},
    "orders, chargers, people": {"orders": 0.01, "people": 0.05},
}
"""Orders a step and people, for each robot."""


def steps_of(robots: int) -> int:
    """Return the joint steps of a round."""
    return min(MAX_STEPS, OURS // robots)


def fleet_of(robots: int, kind: str) -> FleetEnv:
    """Return a fleet with a battery for all the steps that are measured."""
    settings, steps = dict(KINDS[kind]), steps_of(robots) * (ROUNDS + 3)
    if "orders" in settings:
        settings["orders"] *= robots
    settings["people"] = max(1, round(robots * settings["people"])) if "people" in settings else 0
    fleet = FleetEnv(LAYOUT, robots, max_steps=steps, battery=steps + 1, **settings)
    fleet.reset(seed=1)
    return fleet


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Return the seconds of a call by the clock and of the processor."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - cpu


@contextmanager
def pogema(fleet: FleetEnv, actions: np.ndarray) -> Iterator[Callable[[int], tuple[float, float]]]:
    """Yield a function that steps POGEMA, on the same floor with the same actions."""
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


@pytest.mark.parametrize("robots", [4, 10, 100, 1_000, 10_000])
def test_robot_steps_a_second(robots: int, measured) -> None:
    stream = np.random.default_rng(0)
    actions = stream.integers(0, WAIT + 1, (CYCLE, robots))
    busy = stream.integers(0, 7, (CYCLE, robots))
    fleets = {kind: fleet_of(robots, kind) for kind in KINDS}
    ours, theirs = steps_of(robots), max(1, THEIRS // robots)

    def step(kind: str) -> None:
        fleet, chosen = fleets[kind], actions if kind == "alone" else busy
        for number in range(ours):
            fleet.step(chosen[number % CYCLE])

    times: dict[str, list[tuple[float, float]]] = {kind: [] for kind in [*KINDS, "POGEMA"]}
    with pogema(fleets["alone"], actions) as step_theirs:
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
    wall, cpu = (a / b for a, b in zip(rates["alone"], rates["POGEMA"], strict=True))
    measured(
        f"robot-steps a second, {robots:,} robots",
        f"{'; '.join(words)}; {wall:.0f} ({cpu:.0f}) times POGEMA; in parentheses by CPU time",
    )
    assert cpu >= 15 or robots != 1000


def rate_of_fleets(fleets: int, robots: int) -> float:
    """Return the robot-steps a second of many fleets together, by CPU time."""
    batch = FleetBatch(fleets, robots=robots, max_steps=OURS, battery=OURS)
    batch.reset(seed=1)
    actions = np.random.default_rng(0).integers(0, WAIT + 1, batch.num_envs)
    return batch.num_envs * CYCLE / timed(lambda: [batch.step(actions) for _ in range(CYCLE)])[1]


def test_lone_robots_on_thousands_of_floors(measured) -> None:
    """Fleets of one are moved by arrays, and each robot takes less time than one of two."""
    fleets, rates = 4096, {1: 0.0, 2: 0.0}
    for _ in range(ROUNDS):
        for robots in rates:
            rates[robots] = max(rates[robots], rate_of_fleets(fleets, robots))
    words = ", ".join(f"{rate:,.0f} with {robots}" for robots, rate in rates.items())
    ratio = rates[1] / rates[2]
    measured(f"robot-steps a second of {fleets:,} fleets by CPU time", f"{words}; {ratio:.2f}")
    assert ratio >= 1.3


@pytest.mark.parametrize("orders", [None, 100.0])
def test_a_reset_of_ten_thousand_robots(orders: float | None, measured) -> None:
    fleet = FleetEnv(LAYOUT, 10_000, orders=orders, max_steps=1000, battery=1000)
    wall, cpu = (min(each) for each in zip(*(timed(fleet.reset) for _ in range(9)), strict=True))
    what = f"reset of 10,000 robots{' with 100,000 orders' if orders else ''}"
    measured(what, f"{wall:.3f} s, {cpu:.3f} s of CPU time")
    assert cpu < 0.1


def towards_goals(arrays: Any, mask: np.ndarray, stream: np.random.Generator) -> np.ndarray:
    """Return actions that pick and deliver, or move towards the goal, or now and then at random."""
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
    """With orders, chargers and people; a new episode every thousand steps."""
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
        f"memory of {robots * steps:,} robot-steps with orders, chargers and people",
        f"{sizes[1] / 2**20:.1f} MB after two tenths, {sizes[-1] / 2**20:.1f} MB at the end; "
        f"{delivered:,} deliveries",
    )
    assert sizes[-1] - sizes[1] <= 8 * 2**20


SHARE = float(os.environ.get("TRUTH_SHARE", "1"))
LONE_STEPS = round(250_000 * SHARE)
JOINT_ACTIONS = {2: 8000, 5: 5000, 12: 4000, 30: 2000, 100: 1000}


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_of_one_equals_the_warehouse(backend: str, measured) -> None:
    episodes = random_lone_steps_equal(LONE_STEPS, seed=7, backend=backend)
    measured(
        f"a fleet of one against WarehouseEnv, {backend}",
        f"{LONE_STEPS:,} random steps in {episodes:,} episodes, 0 differences",
    )


def test_nominal_bodies_equal_the_grid(measured) -> None:
    stops, moves = Counter[str](), 0
    for robots, joint_actions in JOINT_ACTIONS.items():
        stops += bodies_move_as_the_grid(robots, round(joint_actions * SHARE), seed=robots)
        moves += round(joint_actions * SHARE)
    words = ", ".join(f"{count:,} {what}" for what, count in stops.most_common())
    measured(
        f"fleets of bodies against the grid, {moves:,} joint actions of 2 to 100 robots",
        f"0 differences; {words}",
    )


MAX_STATES = 15_000
SIDES = (0, 1), (1, 0), (0, -1), (-1, 0)


def can_work(env: FleetEnv) -> bool:
    """Return whether there are moves with which a robot picks or delivers an order that waits."""
    people, waiting = walks(env), [env.orders[index].pickup for index in env.open_orders]
    for robot, cell in enumerate(env.cells):
        index = env.order_of[robot]
        if env.loaded[robot] and index is not None:
            targets = [env.orders[index].dropoff]
        else:
            targets = waiting if index is None else [*waiting, env.orders[index].pickup]
        others = frozenset(env.cells) - {cell}
        if any(has_way(env, cell, others, people, target) for target in {*targets}):
            return True
    return False


def walks(env: FleetEnv) -> list[Any]:
    """Return the distances to where each person walks, or ``None``."""
    crowd: Any = env._engine.crowd
    if not crowd._walks_to_stations:
        return [None] * len(env.people)
    ways, fields = crowd._ways, []
    for goal in crowd._goals[0].tolist():
        first = ways._first[0] + goal * ways._size[0]
        number = int(np.flatnonzero(ways._is_goal[first : first + ways._size[0]])[0])
        fields.append(distances(env.layout, [env.layout.cell(number)]))
    return fields


def has_way(
    env: FleetEnv, start: Cell, others: frozenset[Cell], fields: list[Any], target: Cell
) -> bool:
    """Return whether a robot can get to a cell, or the search for it was given up."""
    ways = distances(env.layout, [target])
    people = tuple((cell, field is None) for cell, field in zip(env.people, fields, strict=True))
    first = start, others, people
    known, heap = {first}, [(ways[start], 0, first)]
    while heap:
        chief, robots, people = heappop(heap)[-1]
        if chief == target or len(known) > MAX_STATES:
            return True
        taken, after = {chief, *robots, *(cell for cell, _ in people)}, list[Any]()
        for cell in (chief, *robots, *(cell for cell, _ in people)):
            for down, right in SIDES:
                to = cell[0] + down, cell[1] + right
                if to in taken or not env.layout.is_open(to):
                    continue
                if cell == chief:
                    after.append((to, robots, people))
                elif cell in robots:
                    after.append((chief, robots - {cell} | {to}, people))
                else:
                    [person] = [at for at, each in enumerate(people) if each[0] == cell]
                    field = fields[person]
                    is_free = people[person][1] or field[cell] == 0
                    if is_free or field[to] < field[cell]:
                        moved = (*people[:person], (to, is_free), *people[person + 1 :])
                        after.append((chief, robots, moved))
        for state in after:
            if state not in known:
                known.add(state)
                heappush(heap, (ways[state[0]], len(known), state))
    return False


PLANNERS, ASSIGNMENTS = ["pibt", "pibt-lanes"], ["urgent", "hungarian", "nearest"]
FLEETS, CHARGED_FLEETS, STEPS, LONG_STRETCH, SUPPLY = 200, 100, 800, 100, 1.2
SHORT_STRETCH, LOOK_EVERY = 20, 5
FOREVER = 10**6


class Shift(NamedTuple):
    """The longest stretch, the most steps of one in which something could be picked or delivered,
    the longest time for which robots enclosed a person, and measures.
    """

    stretch: int
    possible: int
    enclosed: int
    delivered: int
    stranded: int


def drive(layout: Layout, robots: int, planner: str, assignment: str, seed: int, **settings: Any):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = FleetEnv(layout, robots, dispatch=False, **settings)
    agent = make_fleet_agent(planner, assignment, seed, layout, robots)
    env.reset(seed=seed)
    last, stretch, enclosed, longest, loaded = 0, 0, [0] * len(env.people), 0, env.loaded
    can, could, possible = True, 0, 0
    while not all(env.ended):
        env.step(agent.act(env))
        if env.loaded != loaded or all(order.delivered is not None for order in env.orders):
            last, can, could = env.steps, True, -1
        since = env.steps - last
        if env.people and since > SHORT_STRETCH and since % LOOK_EVERY == 0:
            can = can_work(env)
        could += can
        possible = max(possible, could)
        stretch, loaded, cells = max(stretch, since), env.loaded, set(env.cells)
        for person, cell in enumerate(env.people):
            is_free = any(side not in cells for side in sides(layout, cell))
            enclosed[person] = 0 if is_free else enclosed[person] + 1
            longest = max(longest, enclosed[person])
    return Shift(stretch, possible, longest, env.measures.delivered, env.measures.stranded)


def sides(layout: Layout, cell: Cell) -> list[Cell]:
    """Return the open cells beside a cell."""
    return [
        (cell[0] + down, cell[1] + right)
        for down, right in SIDES
        if layout.is_open((cell[0] + down, cell[1] + right))
    ]


def aisles(stream: random.Random, seed: int) -> Layout:
    sizes = stream.randint(2, 4), stream.randint(2, 4), stream.randint(3, 6), stream.randint(1, 2)
    stations = {"pickups": stream.randint(3, 6), "dropoffs": stream.randint(2, 3)}
    return shelf_layout(*sizes, 1, seed=seed, **stations)


def corridors(stream: random.Random, has_loops: bool) -> Layout:
    """Return a tree of corridors; or loops, with a wall open at each end of a corridor."""
    height, width = stream.randint(3, 5), stream.randint(3, 6)
    tiles = [[WALL] * (2 * width + 1) for _ in range(2 * height + 1)]
    tiles[1][1], rooms = EMPTY, [(1, 1)]
    while len(rooms) < height * width:
        row, col = stream.choice(rooms)
        down, right = stream.choice(SIDES)
        to = row + 2 * down, col + 2 * right
        if 0 < to[0] < 2 * height and 0 < to[1] < 2 * width and to not in rooms:
            tiles[row + down][col + right] = tiles[to[0]][to[1]] = EMPTY
            rooms.append(to)
    for row, col in rooms if has_loops else []:
        beside = [(row + down, col + right) for down, right in SIDES]
        walls = [each for each in beside if tiles[each[0]][each[1]] == WALL]
        walls = [each for each in walls if 0 < each[0] < 2 * height and 0 < each[1] < 2 * width]
        if len(walls) and sum(tiles[r][c] == EMPTY for r, c in beside) < 2:
            row, col = stream.choice(walls)
            tiles[row][col] = EMPTY
    layout = Layout(["".join(line) for line in tiles])
    pickups, dropoffs = stream.randint(2, 5), stream.randint(2, 4)
    stations = stream.sample(layout.cells(layout.open_cells), pickups + dropoffs)
    return layout.with_tiles(stations[:pickups], stations[pickups:], ())


def crowded(seed: int) -> Shift:
    stream = random.Random(seed)
    kind = seed % 3
    layout = aisles(stream, seed) if kind == 0 else corridors(stream, has_loops=kind == 1)
    most = (0.25, 0.2, 0.08)[kind]
    robots = max(2, round(stream.uniform(0.03, most) * len(layout.open_cells)))
    people = People(stream.randint(1, 3), stream.choice(["stations", "aisles"]))
    return drive(
        layout, robots, stream.choice(PLANNERS), stream.choice(ASSIGNMENTS), seed,
        orders=OrderQueue(2 * robots), people=people, battery=FOREVER, max_steps=STEPS,
    )  # fmt: skip


def charged(seed: int) -> Shift:
    stream = random.Random(1000 + seed)
    while True:
        sizes = [stream.randint(*each) for each in ((2, 5), (2, 5), (3, 7), (1, 2))]
        counts = {"pickups": (3, 8), "dropoffs": (2, 4), "chargers": (2, 8)}
        stations: Any = {name: stream.randint(*each) for name, each in counts.items()}
        robots = int(CHARGE * stations["chargers"] / stream.uniform(SUPPLY, 4))
        try:
            layout = shelf_layout(*sizes, 1 + seed % 2, seed=seed, **stations)
        except LayoutError:
            continue
        if robots <= 0.2 * len(layout.open_cells):
            break
    return drive(
        layout, robots, stream.choice(PLANNERS), stream.choice(ASSIGNMENTS), seed,
        orders=OrderQueue(2 * robots), battery=stream.choice([200, 300, 400, 600]), max_steps=STEPS,
    )  # fmt: skip


def test_a_person_among_eleven_robots_in_narrow_aisles(measured) -> None:
    layout = shelf_layout(3, 4, 5, aisle=1, pickups=6, dropoffs=3, seed=1)
    settings: Any = {"orders": OrderStream(0.4), "people": 1, "battery": FOREVER}
    found = [
        drive(layout, 11, "pibt-lanes", "urgent", seed, max_steps=2500, **settings)
        for seed in range(6)
    ]
    measured(
        "11 robots and a person in aisles of 1, six seeds of 2,500 steps",
        f"stretches without a pick or delivery of at most {max(f.stretch for f in found)} steps, "
        f"the person enclosed for at most {max(f.enclosed for f in found)}, "
        f"{sum(f.delivered for f in found):,} deliveries",
    )
    assert max(each.stretch for each in found) < LONG_STRETCH


@pytest.mark.parametrize(("kind", "name"), [(0, "aisles of 1"), (1, "loops"), (2, "trees")])
def test_random_fleets_with_people(kind: int, name: str, measured) -> None:
    found = [crowded(seed) for seed in range(kind, FLEETS, 3)]
    frozen = sum(each.stretch >= LONG_STRETCH for each in found)
    at_fault = sum(each.possible >= LONG_STRETCH for each in found)
    measured(
        f"random fleets with people, {name}",
        f"{frozen} of {len(found)} have {LONG_STRETCH} steps without a pick or delivery, "
        f"{at_fault} such steps in which one was possible; people enclosed for at most "
        f"{max(each.enclosed for each in found)} steps, "
        f"{sum(each.delivered for each in found):,} deliveries",
    )
    # In trees people have to be lucky too, who do not back off.
    assert at_fault == 0 or kind == 2


def test_robots_in_narrow_aisles_whose_chargers_supply_enough(measured) -> None:
    layout = shelf_layout(4, 4, 6, aisle=1, pickups=4, dropoffs=3, chargers=6, seed=1)
    settings: Any = {"orders": OrderQueue(48), "battery": 200, "max_steps": 2000}
    stranded = [
        drive(layout, 24, planner, "urgent", seed, **settings).stranded
        for planner in PLANNERS
        for seed in range(4)
    ]
    measured("24 robots and 6 chargers in aisles of 1", f"stranded in 8 shifts: {stranded}")
    assert sum(stranded) <= 1  # before turns were kept, 11 to 22 in each shift


def test_random_fleets_with_chargers(measured) -> None:
    found = [charged(seed) for seed in range(CHARGED_FLEETS)]
    stranded = [each.stranded for each in found]
    measured(
        f"random fleets with chargers that supply {SUPPLY} to 4 times the drain",
        f"{sum(stranded)} robots ran empty, in {sum(map(bool, stranded))} of {len(found)} fleets; "
        f"{sum(each.delivered for each in found):,} deliveries",
    )
    assert sum(map(bool, stranded)) <= 2
