"""The maps of POGEMA's benchmark: drawn as the benchmark draws them, or read from a copy of it.

Random maps, mazes and the warehouse come from seeds, and equal the published ones cell for cell.
The puzzles and the parts of cities of MovingAI were made by other means: they are read from a file
``maps.yaml`` of github.com/Cognitive-AI-Systems/pogema-benchmark.

Source: Skrynnik et al. (2025), POGEMA: a benchmark platform for cooperative multi-agent
pathfinding, ICLR; pogema-toolbox has the draws.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from warehouse_core import Layout, LayoutError
from warehouse_core.files.reading import read_file
from warehouse_core.world.tiles import EMPTY, WALL, Cell

MAX_BYTES = 16 * 1024 * 1024
"""Limit on the bytes of a file of maps; the largest of the benchmark has 551,648."""

ENTRY = re.compile(r'^"?([\w-]+)"?: \|-?\n((?:  \S+\n?)+)', re.MULTILINE)
"""A map in ``maps.yaml``: its name, and below it its rows, each after two blanks."""

BESIDE = ((0, -2), (0, 2), (-2, 0), (2, 0))
"""Ways from a post of a maze to the next ones: west, east, north, south."""


def random_map(seed: int) -> Layout:
    """Return a map of 17 to 21 rows and columns, of which 10% to 30% of the cells are walls."""
    stream = np.random.default_rng(seed)
    width, height = int(stream.integers(17, 22)), int(stream.integers(17, 22))
    count = int(width * height * stream.uniform(0.1, 0.3))
    stream, walls = np.random.default_rng(seed), set[Cell]()
    while len(walls) < count:
        col, row = int(stream.integers(width)), int(stream.integers(height))
        walls.add((row, col))
    return _layout(height, width, walls)


def maze_map(seed: int) -> Layout:
    """Return a maze of 17 to 21 rows and columns, whose walls grow from posts, often straight on.

    Posts stand in every second row and column of the maze with its border, which is not returned.
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
            ways = [
                (down, right)
                for down, right in BESIDE
                if 0 <= row + down < height and 0 <= col + right < width
            ]
            chances = np.array([straight if way == last else 1 - straight for way in ways])
            last = ways[stream.choice(len(ways), p=chances / chances.sum())]
            to = row + last[0], col + last[1]
            if to not in walls:
                walls |= {to, (row + last[0] // 2, col + last[1] // 2)}
                row, col = to
    inside = {(row - 1, col - 1) for row, col in walls}
    return _layout(height - 2, width - 2, inside)


def read_maps(path: Path) -> dict[str, Layout]:
    """Return the maps of a file ``maps.yaml`` by name.

    Raises:
        LayoutError: the file has none, or one that is not rows of ``.`` and ``#``.
        OSError: the file cannot be read.
    """
    text = read_file(path, MAX_BYTES).decode("utf-8", "replace")
    maps = {}
    for name, rows in ENTRY.findall(text):
        try:
            maps[name] = Layout(rows.split())
        except LayoutError as error:
            raise LayoutError(f"{path}: map {name}: {error}") from error
    if not maps:
        raise LayoutError(f"{path}: it has no maps as POGEMA's benchmark writes them")
    return maps


def _layout(height: int, width: int, walls: Collection[Cell]) -> Layout:
    return Layout(
        ["".join(WALL if (row, col) in walls else EMPTY for col in range(width))
         for row in range(height)]
    )  # fmt: skip
