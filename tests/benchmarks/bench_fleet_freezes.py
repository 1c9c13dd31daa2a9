"""Fleets among people in narrow aisles that must not freeze, and robots that must not run empty.

A stretch is a number of steps in which nothing is picked or delivered although orders wait. Of a
stretch of a fleet among people those steps are counted too in which something could be, see
``helpers/possible_work.py``: where people stand in each other's way, nobody can.
"""

import random
import warnings
from typing import Any, NamedTuple

import pytest
from helpers.possible_work import can_work

from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, Layout, LayoutError, OrderQueue, OrderStream, shelf_layout
from warehouse_core.fleet import People
from warehouse_core.task.rules import CHARGE
from warehouse_core.world.tiles import EMPTY, WALL, Cell

PLANNERS, ASSIGNMENTS = ["pibt", "pibt-lanes"], ["urgent", "hungarian", "nearest"]
FLEETS, CHARGED_FLEETS, STEPS, LONG_STRETCH, SUPPLY = 200, 100, 800, 100, 1.2
SHORT_STRETCH, LOOK_EVERY = 20, 5
FOREVER = 10**6
SIDES = (0, 1), (1, 0), (0, -1), (-1, 0)


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
