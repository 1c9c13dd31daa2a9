"""Layout files: MovingAI's format in ``.map`` files, lines of tiles in all others.

Errors in a ``.map`` give a line and a column, both counted from 1 as in editors. Robots drive on
land. Swamp can be entered from land, so it becomes floor. Water can only be entered from water, so
it becomes a wall.

Source: https://movingai.com/benchmarks/formats.html
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

from warehouse_core.arguments import instance_of
from warehouse_core.errors import LayoutError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.world.layout import Layout, check_size
from warehouse_core.world.text_lines import (
    MAX_LINE,
    error_at,
    expect_line,
    opened,
    read_line,
    whole_number_at,
)
from warehouse_core.world.tiles import EMPTY, NO_STATIONS, WALL

SUFFIX = ".map"

MAX_BLANKS = 16
"""Limit on the bytes after the last column of a row, including the line end."""

TERRAIN = {".": EMPTY, "G": EMPTY, "S": EMPTY, "@": WALL, "O": WALL, "T": WALL, "W": WALL}

ALLOWED = ". G S (floor), @ O T W (not)"

_BLANK = b" \t\r\n"

_SIZE = re.compile(r"(\w+)\s+(\S+)")

_TO_MAP = NO_STATIONS | str.maketrans({WALL: "@"})


def load_layout(path: str | os.PathLike[str]) -> Layout:
    """Return the layout in a file, whose suffix determines the format.

    Raises:
        LayoutError: the file is not a layout; the message starts with its name.
        OSError: the file cannot be read.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> from warehouse_core.world import load_layout, save_layout
        >>> save_layout(DEFAULT_LAYOUT, "layout.txt")
        >>> load_layout("layout.txt") == DEFAULT_LAYOUT
        True
    """
    return load_map(path) if Path(path).suffix.lower() == SUFFIX else Layout.load(path)


def save_layout(layout: Layout, path: str | Path) -> None:
    """Write a layout to a file, whose suffix determines the format.

    A ``.map`` has no stations and chargers; they become floor.

    Raises:
        OSError: the file cannot be written.
        TypeError: ``layout`` is not a ``Layout``.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core import Layout
        >>> from warehouse_core.world import save_layout
        >>> save_layout(Layout(["P..", "..D"]), "layout.txt")
        >>> print(Path("layout.txt").read_text(), end="")
        P..
        ..D
    """
    instance_of("layout", layout, Layout)
    if Path(path).suffix.lower() == SUFFIX:
        save_map(layout, path)
    else:
        layout.save(path)


def load_map(path: str | os.PathLike[str]) -> Layout:
    """Return the layout in a ``.map`` file, which has no stations.

    A map that is too large is rejected after reading its header. At most ``MAX_BLANKS`` bytes are
    read per row in addition to its cells.

    Raises:
        LayoutError: the file is not a map or is too large; the message starts with its name.
        OSError: the file cannot be read.

    Example:
        >>> from warehouse_core import Layout
        >>> from warehouse_core.world import load_map, save_map
        >>> save_map(Layout(["P.#", "..D"]), "small.map")
        >>> load_map("small.map").rows
        ('..#', '...')
    """
    with opened(path) as file:
        height, width = _read_header(file)
        rows = list(_read_rows(file, height, width))
        _check_end(file, height)
        return Layout(rows)


def save_map(layout: Layout, path: str | Path) -> None:
    """Write a layout to a ``.map`` file, atomically; stations and chargers become floor.

    Raises:
        OSError: the file cannot be written.
        TypeError: ``layout`` is not a ``Layout``.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core import Layout
        >>> from warehouse_core.world import save_map
        >>> save_map(Layout(["P.#", "..D"]), "small.map")
        >>> print(Path("small.map").read_text(), end="")
        type octile
        height 2
        width 3
        map
        ..@
        ...
    """
    instance_of("layout", layout, Layout)
    header = f"type octile\nheight {layout.height}\nwidth {layout.width}\nmap\n"
    with atomic_path(path) as part:
        text = f"{header}{str(layout).translate(_TO_MAP)}\n"
        part.write_text(text, encoding="ascii", newline="\n")


def _read_header(file: BufferedReader) -> tuple[int, int]:
    """Return the height and width in a header, which may have them in either order."""
    expect_line(read_line(file, 1), 1, "type octile")
    sizes: dict[str, int] = {}
    for number in (2, 3):
        line = read_line(file, number)
        wanted = [name for name in ("height", "width") if name not in sizes]
        size = _SIZE.fullmatch(line)
        if not size or size[1] not in wanted:
            allowed = " or ".join(f"'{name} N'" for name in wanted)
            raise error_at(number, 1, f"{line!r} is not allowed; it must be {allowed}")
        column = size.start(2) + 1
        sizes[size[1]] = whole_number_at(size[2], size[1], 1, number, column)
    height, width = sizes["height"], sizes["width"]
    try:
        check_size(height, width)
    except LayoutError as error:
        raise error_at(3, column, str(error)) from error
    expect_line(read_line(file, 4), 4, "map")
    return height, width


def _read_rows(file: BufferedReader, height: int, width: int) -> Iterator[str]:
    """Yield the rows of a map as tiles."""
    known = "".join(TERRAIN).encode()
    tiles = bytes.maketrans(known, "".join(TERRAIN.values()).encode())
    for number in range(5, height + 5):
        data = file.readline(width + MAX_BLANKS + 1)
        if not data:
            raise error_at(number, 1, f"the map ends here; its header says height {height}")
        row = data.rstrip(_BLANK)
        if strange := row.translate(None, known):
            column = row.index(strange[:1])
            shown = row[column:].decode(errors="replace")[0]
            raise error_at(number, column + 1, f"{shown!r} is no terrain; allowed: {ALLOWED}")
        if len(row) != width:
            ends = "ends" if len(row) < width else "goes on"
            message = f"the row {ends} here; its header says width {width}"
            raise error_at(number, min(len(row), width) + 1, message)
        if len(data) > width + MAX_BLANKS:
            message = f"more than MAX_BLANKS = {MAX_BLANKS} blanks follow the row"
            raise error_at(number, len(data), message)
        yield row.translate(tiles).decode("ascii")


def _check_end(file: BufferedReader, height: int) -> None:
    """Raise ``LayoutError`` if anything but a few empty lines follows the last row."""
    for number in range(height + 5, height + 5 + MAX_BLANKS):
        data = file.readline(MAX_LINE)
        if not data:
            return
        if data.strip(_BLANK):
            column = len(data) - len(data.lstrip(_BLANK)) + 1
            raise error_at(number, column, f"the map goes on here; its header says height {height}")
    raise error_at(number, 1, f"MAX_BLANKS = {MAX_BLANKS} or more empty lines at the end")
