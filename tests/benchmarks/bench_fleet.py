"""Robot-steps per second of fleets and of POGEMA, long runs, and fleets that must not freeze.

POGEMA runs with the Python in the environment variable ``POGEMA_PYTHON``, by default with this one.
Times are the best of several rounds, in wall-clock time and in CPU time. ``TRUTH_SHARE=0.1`` runs a
tenth of the steps in long runs.

A stretch is a number of steps in which nothing is picked or delivered although orders are waiting.
If there are people, only steps count in which a pick or delivery was possible, see ``can_work``.
Where people block each other, no robot may be able to work.
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
from warehouse_core.compiled import IS_COMPILED
from warehouse_core.fleet import FleetBatch, People
from warehouse_core.task.rules import CHARGE
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import EMPTY, WALL, Cell

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


def rate_of_fleets(fleets: int, robots: int) -> float:
    """Return the robot-steps of many fleets together per second of CPU time."""
    batch = FleetBatch(fleets, robots=robots, max_steps=OURS, battery=OURS)
    batch.reset(seed=1)
    actions = np.random.default_rng(0).integers(0, WAIT + 1, batch.num_envs)
    return batch.num_envs * CYCLE / timed(lambda: [batch.step(actions) for _ in range(CYCLE)])[1]


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


@pytest.mark.parametrize("fleets", [512, 4096])
def test_a_batch_of_fleets_with_orders(fleets: int, times_faster) -> None:
    """Orders must not take more time than everything else in a step."""
    stream = np.random.default_rng(0)
    actions = stream.integers(0, 7, (CYCLE, 2 * fleets))
    batches = [FleetBatch(fleets, orders=orders, max_steps=MAX_STEPS) for orders in (0.1, None)]

    def step(batch: FleetBatch) -> None:
        for chosen in actions:
            batch.step(chosen)

    for batch in batches:
        batch.reset(seed=1)
    assert times_faster(lambda: step(batches[0]), lambda: step(batches[1])) >= 0.4


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


SHARE = float(os.environ.get("TRUTH_SHARE", "1"))
LONE_STEPS = round(250_000 * SHARE)
JOINT_ACTIONS = {2: 8000, 5: 5000, 12: 4000, 30: 2000, 100: 1000}


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_of_one_equals_the_warehouse(backend: str, measured) -> None:
    episodes = random_lone_steps_equal(LONE_STEPS, seed=7, backend=backend)
    measured(
        f"a fleet of one robot compared with WarehouseEnv, {backend}",
        f"{LONE_STEPS:,} random steps in {episodes:,} episodes, 0 differences",
    )


def test_nominal_bodies_equal_the_grid(measured) -> None:
    stops, moves = Counter[str](), 0
    for robots, joint_actions in JOINT_ACTIONS.items():
        stops += bodies_move_as_the_grid(robots, round(joint_actions * SHARE), seed=robots)
        moves += round(joint_actions * SHARE)
    words = ", ".join(f"{count:,} {kind}" for kind, count in stops.most_common())
    measured(
        f"fleets of bodies compared with the grid, {moves:,} joint actions of 2 to 100 robots",
        f"0 differences; {words}",
    )


MAX_STATES = 15_000
SIDES = (0, 1), (1, 0), (0, -1), (-1, 0)


def can_work(env: FleetEnv) -> bool:
    """Return whether any sequence of moves lets a robot pick or deliver a waiting order."""
    people, waiting = walks(env), [env.orders[index].pickup for index in env.open_orders]
    for robot, cell in enumerate(env.cells):
        index = env.order_of[robot]
        if env.loaded[robot] and index is not None:
            targets = [env.orders[index].dropoff]
        else:
            targets = waiting if index is None else [*waiting, env.orders[index].pickup]
        others = frozenset(env.cells) - {cell}
        if any(can_reach(env, cell, others, people, target) for target in {*targets}):
            return True
    return False


def walks(env: FleetEnv) -> list[Any]:
    """Return the distances to the goal of each person, or ``None`` for people without a goal."""
    walkers: Any = env._engine.walkers
    if not walkers._walks_to_stations:
        return [None] * len(env.people)
    paths, fields = walkers._paths, []
    for goal in walkers._goals[0].tolist():
        first = paths._first[0] + goal * paths._size[0]
        number = int(np.flatnonzero(paths._is_goal[first : first + paths._size[0]])[0])
        fields.append(distances(env.layout, [env.layout.cell(number)]))
    return fields


def can_reach(
    env: FleetEnv, start: Cell, others: frozenset[Cell], fields: list[Any], target: Cell
) -> bool:
    """Return ``True`` if a robot can reach a cell, or if the search has too many states."""
    steps = distances(env.layout, [target])
    people = tuple((cell, field is None) for cell, field in zip(env.people, fields, strict=True))
    first = start, others, people
    known, heap = {first}, [(steps[start], 0, first)]
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
                heappush(heap, (steps[state[0]], len(known), state))
    return False


PLANNERS, ASSIGNMENTS = ["pibt", "pibt:guidance=lanes"], ["urgent", "hungarian", "nearest"]
FLEETS, CHARGED_FLEETS, STEPS, LONG_STRETCH, SUPPLY = 200, 100, 800, 100, 1.2
SHORT_STRETCH, LOOK_EVERY = 20, 5
FOREVER = 10**6


class Shift(NamedTuple):
    """The results of a run.

    Attributes:
        stretch: longest stretch.
        possible: most steps of a stretch in which a pick or delivery was possible.
        enclosed: longest time in steps for which robots enclosed a person.
        delivered: number of deliveries.
        flat: number of robots with a flat battery.
    """

    stretch: int
    possible: int
    enclosed: int
    delivered: int
    flat: int


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
    """Return the open cells next to a cell."""
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
    """Return a tree of corridors, or loops by opening a wall at each dead end."""
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
        nearby = [(row + down, col + right) for down, right in SIDES]
        walls = [each for each in nearby if tiles[each[0]][each[1]] == WALL]
        walls = [each for each in walls if 0 < each[0] < 2 * height and 0 < each[1] < 2 * width]
        if len(walls) and sum(tiles[r][c] == EMPTY for r, c in nearby) < 2:
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
        drive(layout, 11, "pibt:guidance=lanes", "urgent", seed, max_steps=2500, **settings)
        for seed in range(6)
    ]
    measured(
        "11 robots and a person in aisles 1 cell wide, six seeds with 2,500 steps",
        f"at most {max(f.stretch for f in found)} steps without a pick or delivery; the person "
        f"enclosed for at most {max(f.enclosed for f in found)} steps; "
        f"{sum(f.delivered for f in found):,} deliveries",
    )
    assert max(each.stretch for each in found) < LONG_STRETCH


@pytest.mark.parametrize(("kind", "name"), [(0, "aisles 1 cell wide"), (1, "loops"), (2, "trees")])
def test_random_fleets_with_people(kind: int, name: str, measured) -> None:
    found = [crowded(seed) for seed in range(kind, FLEETS, 3)]
    frozen = sum(each.stretch >= LONG_STRETCH for each in found)
    at_fault = sum(each.possible >= LONG_STRETCH for each in found)
    measured(
        f"random fleets with people, {name}",
        f"{frozen} of {len(found)} fleets have {LONG_STRETCH} steps without a pick or delivery, "
        f"and {at_fault} have {LONG_STRETCH} such steps in which one was possible; people enclosed "
        f"for at most {max(each.enclosed for each in found)} steps; "
        f"{sum(each.delivered for each in found):,} deliveries",
    )
    # In trees, progress also depends on people, who do not back off.
    assert at_fault == 0 or kind == 2


def test_robots_in_narrow_aisles_whose_chargers_supply_enough(measured) -> None:
    layout = shelf_layout(4, 4, 6, aisle=1, pickups=4, dropoffs=3, chargers=6, seed=1)
    settings: Any = {"orders": OrderQueue(48), "battery": 200, "max_steps": 2000}
    flat = [
        drive(layout, 24, planner, "urgent", seed, **settings).flat
        for planner in PLANNERS
        for seed in range(4)
    ]
    measured(
        "24 robots and 6 chargers in aisles 1 cell wide",
        f"robots with a flat battery in each of 8 shifts: {flat}",
    )
    assert sum(flat) <= 1  # 11 to 22 in each shift if robots do not take turns


def test_random_fleets_with_chargers(measured) -> None:
    found = [charged(seed) for seed in range(CHARGED_FLEETS)]
    flat = [each.flat for each in found]
    measured(
        f"random fleets with chargers that supply {SUPPLY} to 4 times the consumption",
        f"{sum(flat)} robots with a flat battery in {sum(map(bool, flat))} of {len(found)} fleets; "
        f"{sum(each.delivered for each in found):,} deliveries",
    )
    assert sum(map(bool, flat)) <= 2
