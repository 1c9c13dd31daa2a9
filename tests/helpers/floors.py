"""Floors of another generator than the project's: rooms, shelves, and independent walls."""

import random

from warehouse_core import Layout
from warehouse_core.world.tiles import EMPTY, WALL, Cell, moved

BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))


def rooms(height: int, width: int, seed: int) -> Layout:
    """Return rooms that are halved again and again; one door leads from half to half."""
    stream, tiles = random.Random(f"rooms {seed}"), _hall(height, width)

    def halve(rows: range, columns: range) -> None:
        most = max(len(rows), len(columns))
        if most < 6 or (most < 9 and stream.random() < 0.3):
            return
        is_high = len(rows) >= len(columns)
        length, across = (rows, columns) if is_high else (columns, rows)

        def cell(at: int, beside: int) -> Cell:
            return (at, beside) if is_high else (beside, at)

        places = list(length[2:-2])
        stream.shuffle(places)
        for at in places:
            ends = [cell(at, across[0] - 1), cell(at, across[-1] + 1)]
            if all(tiles[row][col] == WALL for row, col in ends):  # no wall ends at a door
                door = stream.choice(across)
                for beside in across:
                    row, col = cell(at, beside)
                    tiles[row][col] = EMPTY if beside == door else WALL
                for half in (range(length[0], at), range(at + 1, length[-1] + 1)):
                    halve(*((half, across) if is_high else (across, half)))
                return

    halve(range(1, height - 1), range(1, width - 1))
    return _layout(tiles)


def shelves(height: int, width: int, seed: int) -> Layout:
    """Return rows of shelves of two to four cells, with aisles between them and around."""
    length, tiles = random.Random(f"shelves {seed}").randint(2, 4), _hall(height, width)
    for row in range(2, height - 2, 2):
        for col in range(2, width - 2):
            if (col - 1) % (length + 1):
                tiles[row][col] = WALL
    return _layout(tiles)


def scattered(height: int, width: int, seed: int, density: float = 0.45) -> Layout:
    """Return the largest connected part, of 12 cells or more, between independent walls."""
    stream, part = random.Random(f"scattered {seed}"), set[Cell]()
    while len(part) < 12:
        free = {
            (row, col)
            for row in range(1, height - 1)
            for col in range(1, width - 1)
            if stream.random() >= density
        }
        part = max(_parts(free), key=len, default=set())
    tiles = [[EMPTY if (row, col) in part else WALL for col in range(width)]
             for row in range(height)]  # fmt: skip
    return _layout(tiles)


def _parts(free: set[Cell]) -> list[set[Cell]]:
    parts, left = [], sorted(free)
    while left:
        part, todo = {left[0]}, [left[0]]
        while todo:
            cell = todo.pop()
            new = {moved(cell, way) for way in BESIDE} & free - part
            part |= new
            todo += new
        parts.append(part)
        left = [cell for cell in left if cell not in part]
    return parts


def _hall(height: int, width: int) -> list[list[str]]:
    border, row = [WALL] * width, [WALL, *[EMPTY] * (width - 2), WALL]
    return [border, *(row.copy() for _ in range(height - 2)), border.copy()]


def _layout(tiles: list[list[str]]) -> Layout:
    return Layout(["".join(row) for row in tiles])
