"""Layouts made up from sizes and a seed. Every open cell can be reached from every other.

So wherever pickup, dropoff and robot are put or drawn, the item can be delivered.
"""

from __future__ import annotations

import random

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import CHAPTER_START, MAX_CELLS, Layout
from warehouse_core.world.tiles import EMPTY, WALL

MAX_DENSITY = 0.4
"""Densest walls of ``random_layout``; a connected grid of single cells gets hardly denser."""

MIN_OPEN = 4
"""Cells for a pickup and a dropoff, and for those that ``reset(randomize=True)`` draws anew."""


def random_layout(height: int, width: int, density: float, seed: int) -> Layout:
    """Return walls strewn at random inside a border, with one pickup and one dropoff.

    Args:
        height: rows, border included, at least 4.
        width: columns, border included, at least 4.
        density: share of the cells inside the border that are walls, 0 to ``MAX_DENSITY``. A
            layout that is very small, or near the limit, may end a few walls short, where any
            more would cut a loop.
        seed: of the drawing.

    Raises:
        LayoutError: a size or density that is not allowed.
    """
    if min(height, width) < 4 or height * width > MAX_CELLS:
        raise LayoutError(
            f"the size is {height} x {width}; it must be at least 4 x 4 "
            f"and have at most MAX_CELLS = {MAX_CELLS} cells"
        )
    if not 0 <= density <= MAX_DENSITY:
        raise LayoutError(f"density is {density}; it must be 0..{MAX_DENSITY}")
    stream = random.Random(seed)
    border, row = [WALL] * width, [WALL, *[EMPTY] * (width - 2), WALL]
    tiles = [border, *(row.copy() for _ in range(height - 2)), border]
    _strew_walls(tiles, density, stream)
    layout = Layout(["".join(row) for row in tiles])
    pickup, dropoff = stream.sample(range(len(layout.open_cells)), 2)
    return layout.with_stations(layout.open_cell(pickup), layout.open_cell(dropoff))


def shelf_layout(
    shelf_rows: int = 2,
    shelf_columns: int = 3,
    shelf_length: int = 4,
    shelf_depth: int = 1,
    aisle: int = 1,
    seed: int = 0,
) -> Layout:
    """Return a warehouse of shelf blocks with aisles between and around them.

    Args:
        shelf_rows: blocks from top to bottom, at least 1.
        shelf_columns: blocks from left to right, at least 1.
        shelf_length: cells of a block from left to right, at least 1.
        shelf_depth: cells of a block from top to bottom, at least 1.
        aisle: cells between blocks and along the border, at least 1.
        seed: chooses the pickup, beside a shelf, and the dropoff, on the bottom aisle.

    Raises:
        LayoutError: a size that is not allowed.
    """
    sizes = {
        "shelf_rows": shelf_rows,
        "shelf_columns": shelf_columns,
        "shelf_length": shelf_length,
        "shelf_depth": shelf_depth,
        "aisle": aisle,
    }
    _check_sizes(sizes)
    lane = EMPTY * (shelf_columns * (shelf_length + aisle) + aisle)
    shelves = EMPTY * aisle + (WALL * shelf_length + EMPTY * aisle) * shelf_columns
    block = [shelves] * shelf_depth + [lane] * aisle
    inside = [lane] * aisle + block * shelf_rows
    border = WALL * (len(lane) + 2)
    layout = Layout([border, *(f"{WALL}{row}{WALL}" for row in inside), border])
    stream = random.Random(seed)
    beside_shelf = [
        (row, col)
        for row, col in map(layout.open_cell, range(len(layout.open_cells)))
        if row < layout.height - 2 and layout.rows[row + 1][col] == WALL
    ]
    bottom = [(layout.height - 2, col) for col in range(1, layout.width - 1)]
    return layout.with_stations(stream.choice(beside_shelf), stream.choice(bottom))


def benchmark_warehouse(columns: int, rows: int, length: int, depth: int, aisle: int) -> Layout:
    """Return the benchmark map ``warehouse-C-R-L-W-A``, without stations.

    It is ``C(L + A) - A + 5C + 2`` cells wide and ``R(W + A) + A + 2`` high. The ``5C`` are two
    open margins, ``5C // 2`` cells on the left and the rest on the right.

    Args:
        columns: ``C``, shelf blocks from left to right, at least 1.
        rows: ``R``, shelf blocks from top to bottom, at least 1.
        length: ``L``, cells of a block from left to right, at least 1.
        depth: ``W``, cells of a block from top to bottom, at least 1.
        aisle: ``A``, cells between blocks, and along the top and the bottom border, at least 1.

    Raises:
        LayoutError: a size that is not allowed, or more than ``MAX_CELLS`` cells.

    Source: Stern et al. (2019), Multi-Agent Pathfinding: Definitions, Variants, and Benchmarks.
    """
    _check_sizes(
        {"columns": columns, "rows": rows, "length": length, "depth": depth, "aisle": aisle}
    )
    width = columns * (length + aisle) - aisle + 5 * columns + 2
    height = rows * (depth + aisle) + aisle + 2
    if height * width > MAX_CELLS:
        raise LayoutError(f"{height} x {width} cells are more than MAX_CELLS = {MAX_CELLS}")
    left = 5 * columns // 2
    blocks = (EMPTY * aisle).join([WALL * length] * columns)
    shelves = f"{WALL}{EMPTY * left}{blocks}".ljust(width - 1, EMPTY) + WALL
    lane = f"{WALL}{EMPTY * (width - 2)}{WALL}"
    inside = [lane] * aisle + ([shelves] * depth + [lane] * aisle) * rows
    return Layout([WALL * width, *inside, WALL * width])


def _check_sizes(sizes: dict[str, int]) -> None:
    for name, size in sizes.items():
        if size < 1:
            raise LayoutError(f"{name} is {size}; it must be at least 1")


def _strew_walls(tiles: list[list[str]], density: float, stream: random.Random) -> None:
    """Build walls one by one in random order, none that would cut the open cells apart."""
    height, width = len(tiles), len(tiles[0])
    candidates = [(r, c) for r in range(1, height - 1) for c in range(1, width - 1)]
    wanted = min(round(density * len(candidates)), len(candidates) - MIN_OPEN)
    candidates.remove(CHAPTER_START)  # robots start there by default
    while wanted > 0:
        stream.shuffle(candidates)
        left = []
        for row, col in candidates:
            if wanted > 0 and not _joins_neighbours(tiles, row, col):
                tiles[row][col] = WALL
                wanted -= 1
            else:
                left.append((row, col))
        if len(left) == len(candidates):
            return
        # New walls may have made a cell a dead end, which can be walled up after all.
        candidates = left


_RING = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))


def _joins_neighbours(tiles: list[list[str]], row: int, col: int) -> bool:
    """Say whether open neighbours of a cell might be cut apart without it.

    They surely are not when one unbroken arc of open cells among the eight around joins them all.
    """
    ring = [tiles[row + down][col + right] == EMPTY for down, right in _RING]
    arcs = 0
    for side in range(0, 8, 2):
        # An open side starts a new arc unless the corner and the side before it are open too.
        arcs += ring[side] and not (ring[side - 1] and ring[side - 2])
    return arcs > 1
