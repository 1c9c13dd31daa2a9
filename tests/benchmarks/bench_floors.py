"""Fleets on random floors that nobody tuned for: no frozen fleets, and no flat batteries.

The floors are aisles of one cell, loops, trees and rooms with doors, with up to 0.35 robots per
cell, 0 to 3 people, batteries of 120 to 240 steps, and chargers that supply 1.2 to 2.2 times the
consumption. ``FLOORS=200`` sets the number of floors. A fleet is frozen if nothing was picked or
delivered for ``LONG`` steps in which a charged robot had a path to its goal without people and
robots with flat batteries.
"""

import math
import os
import random
import time
import warnings
from typing import Any, NamedTuple

import numpy as np

from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, Layout, OrderQueue, shelf_layout
from warehouse_core.fleet import People
from warehouse_core.task.rules import CHARGE
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import EMPTY, WALL, Cell

FLOORS, STEPS, LONG, LOOK_EVERY = int(os.environ.get("FLOORS", "40")), 600, 100, 5
FOREVER, FIRST_SEED = 10**6, 77_000
KINDS = "aisles", "loops", "trees", "rooms"
SIDES = (0, 1), (1, 0), (0, -1), (-1, 0)


class Case(NamedTuple):
    """A floor and its fleet; ``battery`` is ``FOREVER`` without chargers."""

    layout: Layout
    robots: int
    people: int
    habit: str
    battery: int


class Outcome(NamedTuple):
    """The results of a shift; ``stood`` is the longest time in steps of a frozen fleet."""

    case: Case
    delivered: int
    flat: int
    stood: int
    slowest: float


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


def rooms(stream: random.Random) -> Layout:
    """Return square rooms; each is reachable through doors of one cell."""
    side, height, width = stream.randint(3, 4), stream.randint(2, 4), stream.randint(2, 4)
    pitch = side + 1
    tiles = [["#"] * (width * pitch + 1) for _ in range(height * pitch + 1)]
    for row in range(height * pitch):
        for col in range(width * pitch):
            if row % pitch and col % pitch:
                tiles[row][col] = "."
    places = [(row, col) for row in range(height) for col in range(width)]
    part = {place: number for number, place in enumerate(places)}
    walls = [(a, b) for a in places for b in ((a[0], a[1] + 1), (a[0] + 1, a[1])) if b in part]
    stream.shuffle(walls)
    for (row, col), other in walls:
        joined, into = part[other], part[row, col]
        if joined != into or stream.random() < 0.4:
            part = {place: into if each == joined else each for place, each in part.items()}
            at = 1 + stream.randrange(side)
            if other[0] == row:
                tiles[row * pitch + at][other[1] * pitch] = "."
            else:
                tiles[other[0] * pitch][col * pitch + at] = "."
    layout = Layout(["".join(line) for line in tiles])
    pickups, dropoffs = stream.randint(2, 6), stream.randint(2, 4)
    found = stream.sample(layout.cells(layout.open_cells), pickups + dropoffs)
    return layout.with_tiles(found[:pickups], found[pickups:], ())


def case_of(number: int) -> Case:
    """Return the case with a number; every charger is reachable with half a battery."""
    stream, kind = random.Random(FIRST_SEED + number), KINDS[number % len(KINDS)]
    while True:
        if kind == "aisles":
            layout = aisles(stream, number)
        elif kind == "rooms":
            layout = rooms(stream)
        else:
            layout = corridors(stream, has_loops=kind == "loops")
        cells = layout.cells(layout.open_cells)
        robots, people = (
            max(2, round(stream.uniform(0.05, 0.35) * len(cells))),
            stream.randint(0, 3),
        )
        battery, habit = FOREVER, stream.choice(["stations", "aisles"])
        if stream.random() < 0.6:
            battery = stream.choice([120, 160, 200, 240])
            count = math.ceil(stream.uniform(1.2, 2.2) * robots / CHARGE)
            free = [cell for cell in cells if cell not in layout.pickups + layout.dropoffs]
            if count > len(free) // 4:
                continue
            chargers = stream.sample(free, count)
            layout = layout.with_tiles(layout.pickups, layout.dropoffs, chargers)
            far = [distances(layout, [each]).ravel()[layout.open_cells].max() for each in chargers]
            if max(far) > battery / 2:
                continue
        if robots + people <= 0.5 * len(cells):
            return Case(layout, robots, people, habit, battery)


def can_work(env: FleetEnv) -> bool:
    """Return whether a charged robot has a path without people and flat robots to its goal."""
    arrays: Any = env.arrays()
    is_loaded = np.asarray(arrays["has_item"])[:, None] != 0
    goals = np.where(is_loaded, arrays["dropoff_pos"], arrays["pickup_pos"]).tolist()
    charged = [units > 0 for units in env.battery]
    closed = {cell for cell, is_charged in zip(env.cells, charged, strict=True) if not is_charged}
    closed |= set(env.people)
    return any(
        is_charged and tuple(goal) in reached(env.layout, cell, closed)
        for cell, goal, is_charged in zip(env.cells, goals, charged, strict=True)
    )


def reached(layout: Layout, cell: Cell, closed: set[Cell]) -> set[Cell]:
    """Return the cells that can be reached from a cell without entering closed ones."""
    found, left = {cell}, [cell]
    while left:
        row, col = left.pop()
        for down, right in SIDES:
            to = row + down, col + right
            if to not in found and to not in closed and layout.is_open(to):
                found.add(to)
                left.append(to)
    return found


def run(number: int, planner: str = "auto") -> Outcome:
    case = case_of(number)
    people: Any = People(case.people, case.habit) if case.people else 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = FleetEnv(
            case.layout, case.robots, orders=OrderQueue(2 * case.robots), people=people,
            battery=case.battery, max_steps=STEPS, dispatch=False,
        )  # fmt: skip
    agent = make_fleet_agent(planner, "urgent", number, case.layout, case.robots)
    env.reset(seed=number)
    last, stood, most, loaded, slowest = 0, 0, 0, env.loaded, 0.0
    while not all(env.ended):
        begin = time.process_time()
        actions = agent.act(env)
        if env.steps:  # the first step prepares the planner
            slowest = max(slowest, time.process_time() - begin)
        env.step(actions)
        if env.loaded != loaded:
            last, stood, loaded = env.steps, 0, env.loaded
        if env.steps > last and (env.steps - last) % LOOK_EVERY == 0:
            stood += LOOK_EVERY if can_work(env) else 0
        most = max(most, stood)
    return Outcome(case, env.measures.delivered, env.measures.stranded, most, slowest)


def test_fleets_on_random_floors(measured) -> None:
    found = [run(number) for number in range(FLOORS)]
    frozen = sum(each.stood >= LONG for each in found)
    figures = [
        f"{frozen} of {FLOORS} fleets frozen",
        f"{sum(each.delivered for each in found):,} deliveries",
        f"slowest step {1000 * max(each.slowest for each in found):.0f} ms",
    ]
    for words, has_people in ("without people", False), ("with people", True):
        those = [
            each for each in found
            if each.case.battery != FOREVER and bool(each.case.people) == has_people
        ]  # fmt: skip
        figures.append(
            f"flat batteries in {sum(each.flat > 0 for each in those)} of {len(those)} fleets "
            f"{words} ({sum(each.flat for each in those)} robots)"
        )
    measured("random floors", "; ".join(figures))
    assert frozen <= FLOORS // 20
