"""Layout generators.

In every generated layout each open cell is reachable from every other. So the item can always be
delivered, wherever the pickup, the dropoff and the robot are placed.
"""

from __future__ import annotations

import random

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import real_number, seed_number, whole_number
from warehouse_core.errors import LayoutError
from warehouse_core.wording import brief
from warehouse_core.world.layout import CHAPTER_START, MAX_CELLS, Layout, check_size
from warehouse_core.world.tiles import EMPTY, WALL, Cell

MAX_DENSITY = 0.4
"""Limit for ``random_layout``. Walls can hardly be denser without disconnecting open cells."""

KIVA_PARKING = ".SS.SS."
"""A row of the parking blocks at both sides of ``kiva_warehouse``; robots start at ``S``."""

MIN_OPEN = 4
"""Fewest open cells: a pickup, a dropoff, and two cells for their next random places."""


def random_layout(height: int, width: int, density: float, seed: int) -> Layout:
    """Return a layout of random walls inside a border, with one pickup and one dropoff.

    Args:
        height: rows, border included, at least 4.
        width: columns, border included, at least 4.
        density: share of walls in the cells inside the border, 0 to ``MAX_DENSITY``. A very small
            or very dense layout may have a few walls fewer, because more walls would disconnect
            open cells.
        seed: seed of the random numbers.

    Raises:
        LayoutError: a size or density that is not allowed.
        ValueError: a negative seed.
        TypeError: a size or a seed that is not an integer.

    Example:
        >>> from warehouse_core import random_layout
        >>> for row in random_layout(6, 12, density=0.2, seed=1).rows:
        ...     print(row)
        ############
        #..##..#...#
        ##.#.....#.#
        #P.......D.#
        #......#.#.#
        ############
    """
    height, width = whole_number("height", height), whole_number("width", width)
    if min(height, width) < 4:
        raise LayoutError(
            f"the size is {brief(height)} x {brief(width)}; it must be at least 4 x 4"
        )
    check_size(height, width)
    try:
        density = real_number("density", density, 0, MAX_DENSITY)
    except ValueError as error:
        raise LayoutError(str(error)) from None
    stream = random.Random(seed_number(seed))
    border, row = [WALL] * width, [WALL, *[EMPTY] * (width - 2), WALL]
    tiles = [border, *(row.copy() for _ in range(height - 2)), border]
    _scatter_walls(tiles, density, stream)
    layout = Layout(["".join(row) for row in tiles])
    pickup, dropoff = stream.sample(range(len(layout.open_cells)), 2)
    return layout.with_stations(layout.open_cell(pickup), layout.open_cell(dropoff))


def maze_layout(height: int, width: int, seed: int) -> Layout:
    """Return a perfect maze, in which exactly one path connects any two open cells.

    All paths are one cell wide. The maze has no stations. It is made by a random walk that goes
    back whenever it is stuck.

    Args:
        height: rows, border included, odd and at least 5.
        width: columns, border included, odd and at least 5.
        seed: seed of the random numbers.

    Raises:
        LayoutError: a size that is not allowed.
        ValueError: a negative seed.
        TypeError: a size or a seed that is not an integer.

    Example:
        >>> from warehouse_core.world.generators import maze_layout
        >>> for row in maze_layout(5, 11, seed=1).rows:
        ...     print(row)
        ###########
        #.....#...#
        #####.###.#
        #.........#
        ###########
    """
    height, width = whole_number("height", height), whole_number("width", width)
    if min(height, width) < 5 or not (height % 2 and width % 2):
        raise LayoutError(
            f"the size is {brief(height)} x {brief(width)}; a maze must have odd sides of at "
            "least 5"
        )
    check_size(height, width)
    stream = random.Random(seed_number(seed))
    tiles = [[WALL] * width for _ in range(height)]
    row, col = CHAPTER_START
    tiles[row][col] = EMPTY
    path = [CHAPTER_START]
    while path:
        row, col = path[-1]
        choices = [
            (down, right)
            for down, right in _RING[::2]
            if 0 < row + 2 * down < height and 0 < col + 2 * right < width
            and tiles[row + 2 * down][col + 2 * right] == WALL
        ]  # fmt: skip
        if not choices:
            path.pop()
            continue
        down, right = stream.choice(choices)
        tiles[row + down][col + right] = tiles[row + 2 * down][col + 2 * right] = EMPTY
        path.append((row + 2 * down, col + 2 * right))
    return Layout(["".join(row) for row in tiles])


def shelf_layout(
    shelf_rows: int = 2,
    shelf_columns: int = 3,
    shelf_length: int = 4,
    shelf_depth: int = 1,
    aisle: int = 1,
    seed: int = 0,
    *,
    pickups: int = 1,
    dropoffs: int = 1,
    chargers: int = 0,
) -> Layout:
    """Return a warehouse of shelf blocks with aisles between and around them.

    Several stations of the same kind are spread evenly and are never neighbours. Robots can drive
    around every station.

    Args:
        shelf_rows: blocks from top to bottom, at least 1.
        shelf_columns: blocks from left to right, at least 1.
        shelf_length: cells of a block from left to right, at least 1.
        shelf_depth: cells of a block from top to bottom, at least 1.
        aisle: cells between blocks and along the border, at least 1.
        seed: seed of the random places of stations and chargers.
        pickups: number of pickups, at least 1. They are above shelves.
        dropoffs: number of dropoffs, at least 1. They are on the bottom aisle.
        chargers: number of chargers. They are along the left and the right border.

    Raises:
        LayoutError: a size or a number that is not allowed, or more than ``MAX_CELLS`` cells.
        ValueError: a negative seed.
        TypeError: an argument that is not an integer.

    Example:
        >>> from warehouse_core import shelf_layout
        >>> for row in shelf_layout(1, 2, pickups=2, chargers=1).rows:
        ...     print(row)
        #############
        #...P....P..#
        #C####.####.#
        #......D....#
        #############
    """
    sizes = {
        "shelf_rows": shelf_rows,
        "shelf_columns": shelf_columns,
        "shelf_length": shelf_length,
        "shelf_depth": shelf_depth,
        "aisle": aisle,
    }
    stream = random.Random(seed_number(seed))
    layout = _blocks(sizes)
    above_shelf = [
        (row, col)
        for row, col in map(layout.open_cell, range(len(layout.open_cells)))
        if row < layout.height - 2 and layout.rows[row + 1][col] == WALL
    ]
    bottom = [(layout.height - 2, col) for col in range(1, layout.width - 1)]
    # These exclude the default start and the bottom aisle; pickups are never at the border.
    sides = [(row, col) for col in (1, layout.width - 2) for row in range(2, layout.height - 2)]
    return layout.with_tiles(
        _spread("pickups", pickups, 1, above_shelf, stream),
        _spread("dropoffs", dropoffs, 1, bottom, stream),
        _spread("chargers", chargers, 0, sides, stream),
    )


def _spread(
    name: str, count: int, least: int, cells: list[Cell], stream: random.Random
) -> list[Cell]:
    """Return ``count`` of the cells at even distances, the first of them chosen at random."""
    most, count = max(1, len(cells) // 2), whole_number(name, count)
    if not least <= count <= most:
        raise LayoutError(
            f"{name} is {brief(count)}; it must be {least}..{most} in a layout of this size"
        )
    first = stream.choice(range(len(cells))) if count else 0
    return [cells[(first + i * len(cells) // count) % len(cells)] for i in range(count)]


def benchmark_warehouse(columns: int, rows: int, length: int, depth: int, aisle: int) -> Layout:
    """Return the benchmark map ``warehouse-C-R-L-W-A``, without stations.

    It is ``C(L + A) - A + 5C + 2`` cells wide and ``R(W + A) + A + 2`` high. The ``5C`` columns
    are open margins: ``5C // 2`` on the left, and the others on the right.

    Args:
        columns: ``C``, shelf blocks from left to right, at least 1.
        rows: ``R``, shelf blocks from top to bottom, at least 1.
        length: ``L``, cells of a block from left to right, at least 1.
        depth: ``W``, cells of a block from top to bottom, at least 1.
        aisle: ``A``, cells between blocks and along the top and bottom borders, at least 1.

    Raises:
        LayoutError: a size that is not allowed, or more than ``MAX_CELLS`` cells.

    Source: Stern et al. (2019), Multi-Agent Pathfinding: Definitions, Variants, and Benchmarks.

    Example:
        >>> from warehouse_core.world import benchmark_warehouse
        >>> layout = benchmark_warehouse(columns=10, rows=20, length=10, depth=2, aisle=1)
        >>> layout.height, layout.width
        (63, 161)
    """
    sizes = {"rows": rows, "columns": columns, "length": length, "depth": depth, "aisle": aisle}
    _, columns, *_ = _checked_sizes(sizes)
    left = 5 * columns // 2
    return _blocks(sizes, (left, 5 * columns - left))


def kiva_warehouse(
    rows: int = 8, columns: int = 3, length: int = 10
) -> tuple[Layout, NDArray[np.intp], NDArray[np.intp]]:
    """Return the warehouse of papers on lifelong path finding, without stations.

    It is ``columns * (length + 1) + 13`` cells wide and ``4 * rows + 1`` high and has no border.
    By default it has 33 x 46 cells, 192 starts and 480 goals.

    Args:
        rows: shelves from top to bottom, at least 1.
        columns: shelves from left to right, at least 1.
        length: cells of a shelf from left to right, at least 1.

    Returns:
        The layout, the starts and the goals. Starts and goals are cell numbers ``row * W + col``.
        The starts are in parking blocks at both sides, and the goals above and below shelves.

    Raises:
        LayoutError: a size that is not allowed, or more than ``MAX_CELLS`` cells.

    Source: Li et al. (2021), Lifelong multi-agent path finding in large-scale warehouses, AAAI.
    """
    sizes = {"rows": rows, "columns": columns, "length": length}
    rows, columns, length = _checked_sizes(sizes)
    width = columns * (length + 1) - 1 + 2 * len(KIVA_PARKING)
    check_size(4 * rows + 1, width)
    goals, shelves = (".".join([tile * length] * columns) for tile in "G#")
    lines = [f"{KIVA_PARKING}{inside}{KIVA_PARKING}" for inside in (goals, shelves, goals)]
    aisle = EMPTY * width
    text = [aisle, *[*lines, aisle] * rows]
    marks = np.array([list(line) for line in text]).ravel()
    layout = Layout([line.replace("S", EMPTY).replace("G", EMPTY) for line in text])
    return layout, np.flatnonzero(marks == "S"), np.flatnonzero(marks == "G")


def _checked_sizes(sizes: dict[str, int]) -> list[int]:
    """Return the checked values of named sizes, each 1 to ``MAX_CELLS``."""
    try:
        return [whole_number(name, size, 1, MAX_CELLS) for name, size in sizes.items()]
    except ValueError as error:
        raise LayoutError(str(error)) from None


def _blocks(sizes: dict[str, int], sides: tuple[int, int] | None = None) -> Layout:
    """Return blocks of walls with aisles between them.

    Args:
        sizes: rows and columns of blocks, length and depth of a block, and width of an aisle, by
            the names that errors use.
        sides: numbers of open columns on the left and the right; ``None`` for the aisle's width.
    """
    rows, columns, length, depth, aisle = _checked_sizes(sizes)
    left, right = sides or (aisle, aisle)
    width = left + columns * (length + aisle) - aisle + right + 2
    height = rows * (depth + aisle) + aisle + 2
    check_size(height, width)
    blocks = (EMPTY * aisle).join([WALL * length] * columns)
    shelves = f"{WALL}{EMPTY * left}{blocks}{EMPTY * right}{WALL}"
    lane = f"{WALL}{EMPTY * (width - 2)}{WALL}"
    inside = [lane] * aisle + ([shelves] * depth + [lane] * aisle) * rows
    return Layout([WALL * width, *inside, WALL * width])


def _scatter_walls(tiles: list[list[str]], density: float, stream: random.Random) -> None:
    """Add walls one by one in random order, except those that would disconnect open cells."""
    height, width = len(tiles), len(tiles[0])
    candidates = [(r, c) for r in range(1, height - 1) for c in range(1, width - 1)]
    wanted = min(round(density * len(candidates)), len(candidates) - MIN_OPEN)
    candidates.remove(CHAPTER_START)  # robots start there by default
    while wanted > 0:
        stream.shuffle(candidates)
        skipped = []
        for row, col in candidates:
            if wanted > 0 and not _joins_neighbours(tiles, row, col):
                tiles[row][col] = WALL
                wanted -= 1
            else:
                skipped.append((row, col))
        if len(skipped) == len(candidates):
            return
        # New walls may have turned a skipped cell into a dead end, which can become a wall.
        candidates = skipped


_RING = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""Displacements to the eight cells around a cell, clockwise from north."""


def _joins_neighbours(tiles: list[list[str]], row: int, col: int) -> bool:
    """Return whether a wall in a cell might disconnect its open neighbours.

    The neighbours stay connected if they all lie on one unbroken arc of open cells in the ring of
    eight cells around the cell. The test reads only this ring, so it takes the same time in any
    layout. It also keeps a cell open if only a longer path would connect its neighbours.
    """
    ring = [tiles[row + down][col + right] == EMPTY for down, right in _RING]
    arcs = 0
    for side in range(0, 8, 2):
        # An open side starts a new arc unless the corner and the side before it are open too.
        arcs += ring[side] and not (ring[side - 1] and ring[side - 2])
    return arcs > 1
