"""The episodes of POGEMA's benchmark: its sets of maps, and the starts and goals on each.

They follow from a map and a seed. This module draws as pogema does, so that starts and goals equal
the published ones.

The scenarios in the benchmark's files ``03-warehouse-*.yaml`` have other starts and goals in the
warehouse than its published results, whose costs are lower than the shortest ways there.

Source: pogema, ``generator.py`` and ``envs.py``, github.com/Cognitive-AI-Systems/pogema.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.errors import PlanError
from agents.lab.commands.pogema.maps import maze_map, random_map, read_maps
from agents.mapf.graph import Graph
from agents.mapf.lifelong import NewGoals
from warehouse_core import Layout
from warehouse_core.world.generators import kiva_warehouse
from warehouse_core.world.tables import Integers

SITE = "github.com/Cognitive-AI-Systems/pogema-benchmark"

CITIES = (
    "Berlin_1", "Boston_0", "London_2", "Milan_0", "Moscow_0", "NewYork_1", "Paris_1", "Paris_2",
)  # fmt: skip


class Kind(StrEnum):
    """Whether each robot has one goal, or gets another whenever it is at its goal."""

    ONE_SHOT = "one-shot"
    LIFELONG = "lifelong"


class MapSet(NamedTuple):
    """A set of maps of the benchmark.

    Its episode ``n`` is on map ``n % len(maps)`` with seed ``n // len(maps)``, so that the first
    episodes are on as many cities and puzzles as can be.

    Attributes:
        folder: its folder in the benchmark.
        sizes: numbers of robots.
        maps: names of the maps.
        steps: limits of steps of one-shot and lifelong episodes.
        seeds: number of seeds on each map.
        draw: function that returns the map of a number; ``None`` where maps are read.
    """

    folder: str
    sizes: tuple[int, ...]
    maps: Sequence[str]
    steps: tuple[int, int]
    seeds: int = 1
    draw: Callable[[int], Layout] | None = None

    @property
    def episodes(self) -> int:
        """Number of episodes for each number of robots."""
        return len(self.maps) * self.seeds


FEW, MANY = (8, 16, 24, 32, 48, 64), (32, 64, 96, 128, 160, 192)

SETS = {
    "random": MapSet(
        "01-random", FEW, [f"validation-random-seed-{number:03}" for number in range(128)],
        (128, 256), draw=random_map,
    ),
    "mazes": MapSet(
        "02-mazes", FEW, [f"validation-mazes-seed-{number:03}" for number in range(128)],
        (128, 256), draw=maze_map,
    ),
    "warehouse": MapSet(
        "03-warehouse", MANY, ["wfi_warehouse"], (128, 256), 128, lambda _: kiva_warehouse()[0]
    ),
    "movingai": MapSet(
        "04-movingai", (64, 128, 192, 256),
        [f"{city}_256_{part:02}" for part in range(16) for city in CITIES], (256, 256),
    ),
    "puzzles": MapSet(
        "05-puzzles", (2, 3, 4), [f"puzzle-{number:02}" for number in range(16)], (128, 256), 10
    ),
}  # fmt: skip
"""The sets by name."""


class Instance(NamedTuple):
    """An episode to be run: a map with starts and goals, ``[R]`` cells.

    Attributes:
        collection: name of its set.
        number: number of the episode in its set, from 0.
        map_name: name of its map in the benchmark.
        seed: seed of starts and goals.
        steps: limit of steps.
        targets: cells that the goals of the warehouse are drawn from; empty on other maps, where
            goals are drawn from all cells that a robot can reach.
    """

    kind: Kind
    collection: str
    number: int
    map_name: str
    layout: Layout
    seed: int
    starts: list[int]
    goals: list[int]
    steps: int
    targets: list[int]

    @property
    def robots(self) -> int:
        """``R``."""
        return len(self.starts)

    def new_goals(self) -> NewGoals:
        """Return a function that draws the goals of a lifelong episode; see ``lead``.

        Each robot has random numbers of its own. In the warehouse a goal may come twice: pogema
        compares it without the border of its map with the robot's place, which has the border.
        """
        layout, limit = self.layout, np.iinfo(np.int32).max
        seeds = np.random.default_rng(self.seed).integers(limit, size=self.robots)
        streams = [np.random.default_rng(seed) for seed in seeds]
        choices = [self.targets] * self.robots
        if not self.targets:
            labels = Graph(layout).parts
            cells = {part: np.flatnonzero(labels == part).tolist() for part in labels[self.starts]}
            choices = [cells[labels[start]] for start in self.starts]

        def draw(robot: int, cell: int) -> int:
            while True:
                goal = choices[robot][streams[robot].integers(len(choices[robot]))]
                if goal != cell or self.targets:
                    return goal

        def new_goals(cells: Integers, wanted: Integers) -> Integers:
            wanted = wanted.copy()
            for robot in np.flatnonzero(cells == wanted).tolist():
                wanted[robot] = draw(robot, int(cells[robot]))
            return wanted

        return new_goals


def instances(
    names: Sequence[str], kinds: Sequence[Kind], sizes: Sequence[int], count: int, data: Path | None
) -> Iterator[Instance]:
    """Yield the first episodes of some sets, for each number of robots that a set has.

    Args:
        names: names of the sets.
        kinds: kinds of the episodes.
        sizes: numbers of robots; empty for all.
        count: number of episodes for each number of robots, or all of a set that has fewer.
        data: folder of a copy of the benchmark, for sets whose maps are read.

    Raises:
        PlanError: maps are needed that the folder does not have.
        LayoutError: a file of maps is damaged.
        OSError: a file of maps cannot be read.
    """
    for name in names:
        chosen = SETS[name]
        numbers = range(min(count, chosen.episodes))
        layouts = layouts_of(chosen, len(numbers), data)
        for kind in kinds:
            for robots in chosen.sizes:
                if not sizes or robots in sizes:
                    for number in numbers:
                        layout = layouts[number % len(layouts)]
                        yield make_instance(kind, name, number, layout, robots)


def layouts_of(chosen: MapSet, count: int, data: Path | None) -> list[Layout]:
    """Return the first maps of a set, at most so many, or raise as ``instances`` does."""
    names = chosen.maps[:count]
    if chosen.draw is not None:
        return [chosen.draw(number) for number in range(len(names))]
    if data is None:
        raise PlanError(
            f"the maps of {chosen.folder} are read from a copy of the benchmark; give its folder "
            f"as --data, after: git clone https://{SITE}"
        )
    path = data / "raw_data_MAPF" / chosen.folder / "maps.yaml"
    found = read_maps(path)
    if missing := [name for name in names if name not in found]:
        raise PlanError(f"{path}: it has no map {missing[0]}")
    return [found[name] for name in names]


def make_instance(
    kind: Kind, collection: str, number: int, layout: Layout, robots: int
) -> Instance:
    """Return the episode of a number on its map, with starts and goals as pogema draws them."""
    chosen = SETS[collection]
    seed, map_number = divmod(number, len(chosen.maps))
    if collection == "warehouse":
        _, *ends = kiva_warehouse()
        (starts, targets), stream = (cells.tolist() for cells in ends), np.random.default_rng(seed)
        stream.shuffle(starts)
        stream.shuffle(targets)
        starts, goals = starts[:robots], targets[:robots]
    else:
        (starts, goals), targets = draw_ends(layout, seed, robots), []
    steps = chosen.steps[kind is Kind.LIFELONG]
    name = chosen.maps[map_number]
    return Instance(kind, collection, number, name, layout, seed, starts, goals, steps, targets)


def draw_ends(layout: Layout, seed: int, robots: int) -> tuple[list[int], list[int]]:
    """Return starts and goals: open cells in a random order, by turns one and one in each part."""
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
