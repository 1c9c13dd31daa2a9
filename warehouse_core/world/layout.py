"""The layout of a warehouse: an immutable grid of tiles, read from text and checked.

``H, W`` are the height and width of a layout in cells.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import dedent
from typing import SupportsIndex

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief
from warehouse_core.world.display import display
from warehouse_core.world.tiles import (
    ALLOWED_TILES,
    CHARGER,
    DROPOFF,
    EMPTY,
    MOVE_DELTAS,
    NO_STATIONS,
    PICKUP,
    TILES,
    WALL,
    Cell,
    moved,
)

CHAPTER_START: Cell = (1, 1)
"""Default start of a robot."""

MAX_CELLS = 16_000_000
"""Limit on the cells of a layout. Longer text is rejected before it is parsed."""

MAX_FILE = 2 * MAX_CELLS + 3
"""Limit on the bytes of a file, in which every cell may have a line end, and a byte-order mark."""

MAX_ROWS = 100_000
"""Limit on the rows of a layout, each of which takes memory for a string."""


@dataclass(frozen=True, slots=True, init=False)
class Layout:
    """An ``H`` x ``W`` grid of tiles.

    Args:
        rows: equally long strings of ``#`` wall, ``.`` empty, ``P`` pickup, ``D`` dropoff and
            ``C`` charger.

    Raises:
        LayoutError: there are no rows, rows of different lengths, an unknown character, more than
            ``MAX_CELLS`` cells, or more than ``MAX_ROWS`` rows.
        TypeError: ``rows`` is not a sequence of strings.

    All other fields are computed from ``rows``. Source: the chapter's exercise.

    Example:
        >>> from warehouse_core import Layout
        >>> layout = Layout(["P.#", ".#.", "..D"])
        >>> layout.pickups, layout.dropoffs, layout.is_open((0, 2))
        (((0, 0),), ((2, 2),), False)
    """

    rows: tuple[str, ...]
    height: int = field(init=False, compare=False)
    width: int = field(init=False, compare=False)
    pickups: tuple[Cell, ...] = field(init=False, compare=False)
    dropoffs: tuple[Cell, ...] = field(init=False, compare=False)
    chargers: tuple[Cell, ...] = field(init=False, compare=False)
    open_cells: NDArray[np.intp] = field(init=False, compare=False)
    """Numbers of all cells that are not walls, in ascending order and read-only."""

    def __init__(self, rows: Sequence[str]) -> None:
        checked = _checked_rows(rows)
        tiles = np.frombuffer("".join(checked).encode("ascii"), dtype=np.uint8)
        open_cells = np.flatnonzero(tiles != ord(WALL))
        open_cells.setflags(write=False)
        width = len(checked[0])
        marked = (
            tuple(divmod(number, width) for number in np.flatnonzero(tiles == ord(tile)).tolist())
            for tile in (PICKUP, DROPOFF, CHARGER)
        )
        self._fill(checked, marked, open_cells)

    def _fill(
        self,
        rows: tuple[str, ...],
        marked: Iterable[tuple[Cell, ...]],
        open_cells: NDArray[np.intp],
    ) -> None:
        """Set all fields; ``marked`` are the pickups, the dropoffs and the chargers."""
        values = (rows, len(rows), len(rows[0]), *marked, open_cells)
        for name, value in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, name, value)  # a frozen dataclass refuses plain assignment

    @classmethod
    def from_text(cls, text: str) -> Layout:
        """Return the layout in lines of tiles.

        Common indentation and blank lines around the layout are ignored.

        Raises:
            LayoutError: the text is not a valid layout, see the class.
        """
        # In a layout of one column each cell has a line end.
        if len(text) > 2 * MAX_CELLS:
            raise LayoutError(f"layout text is longer than MAX_CELLS = {MAX_CELLS} cells allow")
        _check_rows(text.count("\n"))
        lines = dedent(text).strip("\n").split("\n")
        return cls([line.rstrip() for line in lines])

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Layout:
        """Return the layout in a UTF-8 text file.

        Raises:
            LayoutError: the text is not a valid layout; the message starts with the file's name.
            OSError: the file cannot be read.
        """
        data = read_file(path, MAX_FILE)
        try:
            return cls.from_text(data.decode("utf-8-sig").replace("\r\n", "\n"))
        except UnicodeDecodeError as error:
            raise LayoutError(f"{path}: not UTF-8 text: byte {error.start}") from error
        except LayoutError as error:
            raise LayoutError(f"{path}: {error}") from error

    def save(self, path: str | Path) -> None:
        """Write the layout as text, atomically."""
        with atomic_path(path) as part:
            part.write_text(f"{self}\n", encoding="utf-8", newline="\n")

    _repr_png_ = display  # called by notebooks

    def __str__(self) -> str:
        return "\n".join(self.rows)

    def __repr__(self) -> str:
        return f"<Layout {self.summary()}>"

    def summary(self) -> str:
        """Return size, stations and chargers in words.

        Examples: ``7 x 12, pickup (1, 3), dropoff (5, 6)``; ``9 x 9, no pickups, 2 dropoffs``.
        """
        pickups, dropoffs = _counted("pickup", self.pickups), _counted("dropoff", self.dropoffs)
        chargers = f", {_counted('charger', self.chargers)}" if self.chargers else ""
        return f"{self.height} x {self.width}, {pickups}, {dropoffs}{chargers}"

    def __deepcopy__(self, memo: object) -> Layout:
        return self  # layouts are immutable, and a copied array would be writable

    def __reduce__(self) -> tuple[type[Layout], tuple[tuple[str, ...]]]:
        return Layout, (self.rows,)

    def is_open(self, cell: Cell) -> bool:
        """Return whether ``cell`` is inside the grid and not a wall."""
        row, col = cell
        return 0 <= row < self.height and 0 <= col < self.width and self.rows[row][col] != WALL

    def open_sides(self, cell: Cell) -> tuple[bool, ...]:
        """Return whether the neighbours of ``cell`` to the N, E, S and W are open."""
        return tuple(self.is_open(moved(cell, delta)) for delta in MOVE_DELTAS.values())

    def open_cell(self, rank: int) -> Cell:
        """Return an open cell by its index among the open cells, from 0 in row-major order."""
        return self.cell(self.open_cells[rank])

    def number(self, cell: Cell) -> int:
        """Return the number of a cell, ``row * W + col``."""
        row, col = cell
        return row * self.width + col

    def cell(self, number: SupportsIndex) -> Cell:
        """Return the cell with the number ``row * W + col``."""
        return divmod(int(number), self.width)

    def numbers(self, cells: Iterable[Cell]) -> NDArray[np.intp]:
        """Return the numbers of cells as a new array."""
        width = self.width
        return np.array([row * width + col for row, col in cells], np.intp)

    def cells(self, numbers: Sequence[int] | NDArray[np.integer]) -> list[Cell]:
        """Return the cells with these numbers."""
        width = self.width
        return [divmod(number, width) for number in np.asarray(numbers).tolist()]

    def places(self, numbers: NDArray[np.integer]) -> NDArray[np.intp]:
        """Return the rows and columns ``[..., 2]`` of the cells with the numbers ``[...]``."""
        return np.stack(np.divmod(numbers, self.width), axis=-1)

    def default_start(self) -> Cell:
        """Return the chapter's start if it is open, otherwise the first open cell.

        Raises:
            LayoutError: no cell is open.
        """
        if self.is_open(CHAPTER_START):
            return CHAPTER_START
        if not len(self.open_cells):
            raise LayoutError("the layout has no open cell; a robot needs one to start on")
        return self.open_cell(0)

    def ranks(self, cells: Iterable[Cell]) -> list[int]:
        """Return the indices of open cells among the open cells."""
        numbers = self.numbers(cells)
        return np.searchsorted(self.open_cells, numbers).tolist() if len(numbers) else []

    def describe(self, cell: Cell) -> str:
        """Return a description of a cell for error messages; it may be off the grid."""
        row, col = cell
        if not (0 <= row < self.height and 0 <= col < self.width):
            return (
                f"row {row}, column {col} is off the grid "
                f"(rows 0..{self.height - 1}, columns 0..{self.width - 1})"
            )
        return f"row {row}, column {col} is {TILES[self.rows[row][col]]}"

    def reachable_from(self, cell: Cell) -> set[Cell]:
        """Return all cells that are reachable from ``cell``, including ``cell``."""
        reached, frontier = {cell}, [cell]
        while frontier:
            here = frontier.pop()
            for delta in MOVE_DELTAS.values():
                neighbour = moved(here, delta)
                if neighbour not in reached and self.is_open(neighbour):
                    reached.add(neighbour)
                    frontier.append(neighbour)
        return reached

    def with_stations(self, pickup: Cell | None, dropoff: Cell | None) -> Layout:
        """Return a layout with the same walls and chargers, and only these stations.

        Raises:
            LayoutError: a cell is not open, or both stations are in the same cell.
        """
        pickups, dropoffs = (() if cell is None else (cell,) for cell in (pickup, dropoff))
        return self._with((pickups, dropoffs, self.chargers))

    def with_chargers(self, cells: Iterable[Cell]) -> Layout:
        """Return a layout with the same walls and stations, and only these chargers.

        Raises:
            LayoutError: a cell is not open, or is a station.
        """
        return self.with_tiles(self.pickups, self.dropoffs, cells)

    def with_tiles(
        self, pickups: Iterable[Cell], dropoffs: Iterable[Cell], chargers: Iterable[Cell]
    ) -> Layout:
        """Return a layout with the same walls, and only these stations and chargers.

        Both layouts share the array ``open_cells``, so that a cache that depends only on the walls
        stays valid.

        Raises:
            LayoutError: a cell is not open, or is given for two tiles.
        """
        return self._with(tuple(tuple(sorted(set(c))) for c in (pickups, dropoffs, chargers)))

    def _with(self, marked: tuple[tuple[Cell, ...], ...]) -> Layout:
        rows = list(self.rows)
        for row in {row for row, _ in self.pickups + self.dropoffs + self.chargers}:
            rows[row] = rows[row].translate(NO_STATIONS)
        for cells, tile in zip(marked, (PICKUP, DROPOFF, CHARGER), strict=True):
            for row, col in cells:
                check_open(self, (row, col), TILES[tile])
                if (present := rows[row][col]) != EMPTY:
                    raise LayoutError(
                        f"row {row}, column {col} is to be {TILES[present]} and {TILES[tile]}; "
                        "a cell has only one tile"
                    )
                rows[row] = f"{rows[row][:col]}{tile}{rows[row][col + 1 :]}"
        layout = object.__new__(Layout)
        layout._fill(tuple(rows), marked, self.open_cells)
        return layout


def _counted(name: str, cells: tuple[Cell, ...]) -> str:
    if len(cells) == 1:
        return f"{name} {cells[0]}"
    return f"{len(cells) or 'no'} {name}s"


def check_open(layout: Layout, cell: Cell, name: str) -> None:
    """Raise ``LayoutError`` that starts with ``name`` if a cell is off the grid or a wall."""
    if not layout.is_open(cell):
        raise LayoutError(f"{name} {layout.describe(cell)}; it must be an open cell")


def check_size(height: int, width: int) -> None:
    """Raise ``LayoutError`` for more than ``MAX_ROWS`` rows or ``MAX_CELLS`` cells."""
    _check_rows(height)
    if height * width > MAX_CELLS:
        size = f"{brief(height)} x {brief(width)}"
        raise LayoutError(f"{size} cells are more than MAX_CELLS = {MAX_CELLS}")


def _check_rows(height: int) -> None:
    if height > MAX_ROWS:
        raise LayoutError(
            f"the layout has {brief(height, 100)} rows; at most MAX_ROWS = {MAX_ROWS} are allowed"
        )


def _checked_rows(rows: Sequence[str]) -> tuple[str, ...]:
    if isinstance(rows, str) or not isinstance(rows, Sequence):
        raise TypeError(f"a layout is a list of strings, not {type(rows).__name__}")
    _check_rows(len(rows))
    for index, row in enumerate(rows):
        if not isinstance(row, str):
            raise TypeError(f"row {index} of the layout is {type(row).__name__}, not a string")
    if not rows or not rows[0]:
        raise LayoutError("the layout is empty; it needs at least one row with one cell")
    width = len(rows[0])
    check_size(len(rows), width)
    for index, row in enumerate(rows):
        if not set(row) <= TILES.keys():
            column, tile = next(each for each in enumerate(row) if each[1] not in TILES)
            raise LayoutError(
                f"row {index}, column {column}: {tile!r} is not a tile; allowed: {ALLOWED_TILES}"
            )
        if len(row) != width:
            raise LayoutError(
                f"row {index} has {len(row)} columns where row 0 has {width}; "
                "all rows must be equally long"
            )
    return tuple(map(str, rows))


DEFAULT_LAYOUT = Layout.from_text(
    """
    ############
    #..P....#..#
    #..##...#..#
    #......##..#
    #..#.......#
    #..#..D....#
    ############
    """
)
"""The chapter's warehouse, 7 x 12 cells."""
