"""Planners on the episodes of POGEMA's benchmark, compared with its published results.

Random maps, mazes, the warehouse, starts and goals are generated exactly as in the benchmark. The
environment variable ``POGEMA_DATA`` names a copy of
github.com/Cognitive-AI-Systems/pogema-benchmark with the MovingAI maps and the puzzles, which are
skipped without it.

``published.csv`` has a line for each kind, set, number of robots and algorithm. It gives the mean
wall-clock time of an episode in seconds and, for each episode, the sum of costs or the goals that
were reached in 256 steps. ``-`` stands for an episode that was not solved within the maximum number
of steps, and ``?`` for an episode that was not run. RHCR ran the mazes for 128 steps, so that its
goals there are doubled.

Source: Skrynnik et al. (2025), POGEMA: a benchmark platform for cooperative multi-agent
pathfinding, ICLR; ``generator.py`` and ``envs.py`` of pogema, and pogema-toolbox.
"""

import csv
import math
import os
import re
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from agents.lab.commands.planners.runs import attempt, make_stepper
from agents.mapf.graph import Graph
from agents.mapf.planner import NO_CELLS, Situation
from agents.mapf.problem import Problem
from warehouse_core import Layout
from warehouse_core.compiled import IS_COMPILED
from warehouse_core.world.generators import kiva_warehouse

pytestmark = pytest.mark.usefixtures("processor_clock")

SECONDS = 2.0
"""Seconds allowed for a plan or for a step."""

STEPS = 256
"""Number of steps in a lifelong episode."""

ONE_SHOT = {
    ("random", 64, 20): (20, 0.95),
    ("mazes", 64, 20): (19, 0.95) if IS_COMPILED else (18, 1.0),
    ("warehouse", 192, 20): (20, 0.97),
    ("movingai", 256, 8): (7, 1.0),
    ("puzzles", 4, 160): (150, 1.0),
}
"""Minimum solved episodes and maximum ratio of costs to LaCAM3's, by set, robots and episodes."""

AUTO = "auto:seconds=0.01"

LIFELONG = {
    ("random", 64, 20): 4.3,
    ("mazes", 64, 20): 2.8,
    ("warehouse", 192, 3): 5.6,
    ("movingai", 256, 8): 5.6,
}
"""Goals per step that ``AUTO`` must reach if planners are compiled."""

CITIES = (
    "Berlin_1", "Boston_0", "London_2", "Milan_0", "Moscow_0", "NewYork_1", "Paris_1", "Paris_2",
)  # fmt: skip
READ = {
    "movingai": ("04-movingai", [f"{city}_256_{n:02}" for n in range(16) for city in CITIES], 256),
    "puzzles": ("05-puzzles", [f"puzzle-{n:02}" for n in range(16)], 128),
}
"""Folder, maps and maximum steps of the sets whose maps are read; other sets have 128 steps."""

NEXT_POSTS = ((0, -2), (0, 2), (-2, 0), (2, 0))
"""Offsets from a post of a maze to the next posts in the west, east, north and south."""

Place = tuple[str, int, int]
"""Name of a set, number of robots, number of episodes."""


class Episode(NamedTuple):
    """A map with starts and goals; ``targets`` are the possible goal cells of the warehouse."""

    layout: Layout
    seed: int
    starts: list[int]
    goals: list[int]
    targets: list[int]


def random_map(seed: int) -> Layout:
    """Return a map with 17 to 21 rows and columns, in which 10% to 30% of the cells are walls."""
    stream = np.random.default_rng(seed)
    width, height = int(stream.integers(17, 22)), int(stream.integers(17, 22))
    count = int(width * height * stream.uniform(0.1, 0.3))
    stream, walls = np.random.default_rng(seed), set[tuple[int, int]]()
    while len(walls) < count:
        col, row = int(stream.integers(width)), int(stream.integers(height))
        walls.add((row, col))
    return layout_of(walls, height, width)


def maze_map(seed: int) -> Layout:
    """Return a maze with 17 to 21 rows and columns, whose walls grow from posts, mostly straight.

    Posts are in every second row and column of the maze including its border, which is then
    removed.
    """
    stream = np.random.default_rng(seed)
    width, height = (int(stream.integers(17, 22)) // 2 * 2 + 3 for _ in range(2))
    density, length = stream.uniform(0, 1), int(stream.integers(1, 9))
    straight = stream.uniform(0.75, 0.85)
    stream = np.random.default_rng(seed)
    walls = {(row, col) for row in range(height) for col in (0, width - 1)}
    walls |= {(row, col) for row in (0, height - 1) for col in range(width)}
    for _ in range(int(height * width * density // length)):
        col, row = (2 * int(stream.integers(side // 2)) for side in (width, height))
        walls.add((row, col))
        last = 0, 0
        for _ in range(length):
            moves = [
                (down, right)
                for down, right in NEXT_POSTS
                if 0 <= row + down < height and 0 <= col + right < width
            ]
            chances = np.array([straight if move == last else 1 - straight for move in moves])
            last = moves[stream.choice(len(moves), p=chances / chances.sum())]
            to = row + last[0], col + last[1]
            if to not in walls:
                walls |= {to, (row + last[0] // 2, col + last[1] // 2)}
                row, col = to
    return layout_of({(row - 1, col - 1) for row, col in walls}, height - 2, width - 2)


def layout_of(walls: set[tuple[int, int]], height: int, width: int) -> Layout:
    return Layout(
        ["".join(".#"[(row, col) in walls] for col in range(width)) for row in range(height)]
    )


def read_maps(name: str) -> list[Layout]:
    """Return the maps of a set in the benchmark's file ``maps.yaml``."""
    if "POGEMA_DATA" not in os.environ:
        pytest.skip("POGEMA_DATA does not name a copy of the benchmark")
    folder, names, _ = READ[name]
    text = Path(os.environ["POGEMA_DATA"], "raw_data_MAPF", folder, "maps.yaml").read_text()
    maps = dict(re.findall(r'^"?([\w-]+)"?: \|-?\n((?:  \S+\n?)+)', text, re.MULTILINE))
    return [Layout(maps[each].split()) for each in names]


def episodes_of(place: Place) -> list[Episode]:
    """Return the first episodes of a set, given its name and the numbers of robots and episodes.

    Episode ``n`` is on map ``n % maps`` with seed ``n // maps``.
    """
    name, robots, count = place
    if name == "warehouse":
        return [warehouse_episode(seed, robots) for seed in range(count)]
    if name in READ:
        maps = read_maps(name)
    else:
        draw = {"random": random_map, "mazes": maze_map}[name]
        maps = [draw(number) for number in range(128)]
    found = []
    for number in range(count):
        seed, layout = number // len(maps), maps[number % len(maps)]
        found.append(Episode(layout, seed, *draw_ends(layout, seed, robots), []))
    return found


def warehouse_episode(seed: int, robots: int) -> Episode:
    layout, *ends = kiva_warehouse()
    (starts, targets), stream = (cells.tolist() for cells in ends), np.random.default_rng(seed)
    stream.shuffle(starts)
    stream.shuffle(targets)
    return Episode(layout, seed, starts[:robots], targets[:robots], targets)


def draw_ends(layout: Layout, seed: int, robots: int) -> tuple[list[int], list[int]]:
    """Return starts and goals, which alternate among the shuffled open cells of each part."""
    order, labels = layout.open_cells.tolist(), Graph(layout).parts.tolist()
    np.random.default_rng(seed).shuffle(order)
    left = Counter(labels[cell] for cell in order)
    starts, goals, waiting = list[int](), dict[int, int](), dict[int, int]()
    for cell in order:
        part = labels[cell]
        if part in waiting:
            goals[waiting.pop(part)] = cell
        elif len(starts) < robots and left[part] >= 2:
            left[part] -= 2
            waiting[part] = len(starts)
            starts.append(cell)
    return starts, [goals[robot] for robot in range(len(starts))]


def new_goals_of(one: Episode) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Return a function that draws random goals for a lifelong episode.

    Each robot has its own random generator. In the warehouse a robot may get the same goal twice,
    because pogema compares coordinates with and without the border of its map.
    """
    seeds = np.random.default_rng(one.seed).integers(np.iinfo(np.int32).max, size=len(one.starts))
    streams = [np.random.default_rng(seed) for seed in seeds]
    labels = Graph(one.layout).parts
    choices = [
        one.targets or np.flatnonzero(labels == labels[start]).tolist() for start in one.starts
    ]

    def draw(robot: int, cell: int) -> int:
        while True:
            goal = choices[robot][streams[robot].integers(len(choices[robot]))]
            if goal != cell or one.targets:
                return goal

    def new_goals(cells: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        wanted = wanted.copy()
        for robot in np.flatnonzero(cells == wanted).tolist():
            wanted[robot] = draw(robot, int(cells[robot]))
        return wanted

    return new_goals


def published(kind: str, place: Place) -> dict[str, tuple[np.ndarray, float]]:
    """Return the values of the episodes and the mean seconds per episode, for each algorithm."""
    name, robots, count = place
    words = {"-": math.inf, "?": math.nan}
    found = {}
    with Path(__file__).with_name("published.csv").open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            if (line["kind"], line["set"], line["robots"]) == (kind, name, str(robots)):
                texts = line["episodes"].split()[:count]
                values = np.array([words.get(each) or float(each) for each in texts])
                found[line["algorithm"]] = values, float(line["seconds"])
    return found


@pytest.mark.parametrize("place", ONE_SHOT, ids=str)
def test_plans(place: Place, measured) -> None:
    limit = READ[place[0]][2] if place[0] in READ else 128
    costs, bounds, took, optimal = [], [], [], 0
    for one in episodes_of(place):
        problem = Problem(Graph(one.layout), one.starts, one.goals)
        found = attempt("lacam", 0, problem, SECONDS)
        is_solved = found.makespan is not None and found.makespan <= limit
        costs.append(found.costs if is_solved else math.inf)
        bounds.append(found.bound)
        took.append(found.seconds)
        optimal += found.proved
    bound, theirs = np.array(bounds), published("one-shot", place)
    reference = theirs["LaCAM"][0]
    # If starts, goals or maps differed from the published ones, costs could be below the bound.
    assert (reference >= bound).all()
    rows = theirs | {"lacam": (np.array(costs, float), float(np.mean(took)))}
    for name, (values, seconds) in rows.items():
        own = np.isfinite(values) & (bound > 0)
        both = own & np.isfinite(reference)
        over = values[both] / reference[both]
        figures = [f"{np.isfinite(values).sum()} of {len(values)} solved"]
        if both.any():
            figures.append(f"{(values[own] / bound[own]).mean():.3f} times the bound")
            figures.append(f"{over.mean():.3f} times LaCAM3, worst {over.max():.2f}")
        figures.append(f"{seconds:.2f} s")
        if name == "lacam":
            figures.append(f"{optimal} proved optimal")
        measured(f"one-shot, {place[0]}, {place[1]} robots, {name}", ", ".join(figures))
    solved, most = ONE_SHOT[place]
    assert np.isfinite(rows["lacam"][0]).sum() >= solved
    assert over.mean() <= most


@pytest.mark.parametrize("place", LIFELONG, ids=str)
def test_lifelong_windows(place: Place, measured) -> None:
    planner, least = AUTO, LIFELONG[place]
    rates, took = [], []
    for one in episodes_of(place):
        # Pickups show the goals to planners that learn; robots can pass through them.
        layout = one.layout.with_tiles(one.layout.cells(one.targets), [], [])
        stepper = make_stepper(planner, 0, layout, len(one.starts), SECONDS)
        cells, goals, new_goals = np.array(one.starts), np.array(one.goals), new_goals_of(one)
        nobody, reached, begin = np.zeros(len(cells), np.bool_), 0, time.process_time()
        stepper.reset()
        for _ in range(STEPS):
            cells = stepper.next_cells(Situation(cells, goals, nobody, NO_CELLS))
            reached += np.count_nonzero(cells == goals)
            goals = new_goals(cells, goals)
        rates.append(reached / STEPS)
        took.append(time.process_time() - begin)
    theirs = published("lifelong", place)
    rows = {name: (values / STEPS, seconds) for name, (values, seconds) in theirs.items()}
    rows[planner] = np.array(rates), float(np.mean(took))
    reference = rows["RHCR"][0]
    for name, (values, seconds) in rows.items():
        over = values / reference
        measured(
            f"lifelong, {place[0]}, {place[1]} robots, {name}",
            f"{np.nanmean(values):.2f} goals per step, {np.nanmean(values) / reference.mean():.3f} "
            f"times RHCR, worst {np.nanmin(over):.2f}, {1000 * seconds / STEPS:.1f} ms per step",
        )
    assert np.mean(rates) >= least
