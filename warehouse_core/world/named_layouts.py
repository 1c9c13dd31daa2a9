"""Layouts with names, for repeatable demonstrations such as ``warehouse run --layout trap``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from warehouse_core.errors import LayoutError
from warehouse_core.wording import brief
from warehouse_core.world.generators import shelf_layout
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.map_files import load_layout

GivenLayout = Layout | Sequence[str] | str | os.PathLike[str]
"""A layout, its rows, its text, its name or the path of its file."""

TEXTS = {
    "corridor": """
############
#P........D#
############
""",
    "hall": """
################
#..............#
#..P...........#
#..............#
#..............#
#..............#
#...........D..#
#..............#
################
""",
    "rooms": """
#############
#.....#.....#
#.P...#.....#
#...........#
#.....#.....#
###.#####.###
#.....#.....#
#...........#
#.....#...D.#
#.....#.....#
#############
""",
    "trap": """
###########
#.........#
#...##....#
#....#....#
#.P..#..D.#
#....#....#
#...##....#
#.........#
###########
""",
    "bay": """
###########
#.........#
#..####...#
#.....#...#
#P....#..D#
#..####...#
#.........#
###########
""",
    "maze": """
#####################
#P#.....#.......#...#
#.#####.#.###.#.#.#.#
#.#...#.....#.#.#.#.#
#.#.#.#####.#.#.###.#
#...#.....#.#.#...#.#
#########.###.###.#.#
#.#.....#.#...#.#.#.#
#.#.#.###.#.###.#.#.#
#...#.......#......D#
#####################
""",
    "closed": """
##########
#...#....#
#.P.#....#
#...#..D.#
#...#....#
##########
""",
}

DEFAULT, BAY, SHELVES, DEPOT = "default", "bay", "shelves", "depot"

NAMES = (DEFAULT, *TEXTS, SHELVES, DEPOT)
"""Names of all layouts: the chapter's, seven demonstrations, and two with shelves.

The depot has room for a fleet of about eight robots.
"""


@lru_cache
def named_layout(name: str) -> Layout:
    """Return a layout by name.

    Raises:
        LayoutError: no layout has this name; the message lists all names.
    """
    if name == DEFAULT:
        return DEFAULT_LAYOUT
    if name == SHELVES:
        return shelf_layout(3, 4, 4, 2, 1, seed=1)
    if name == DEPOT:
        return shelf_layout(3, 3, 4, 1, 2, seed=1, pickups=6, dropoffs=3, chargers=4)
    if name not in TEXTS:
        allowed = ", ".join(NAMES)
        raise LayoutError(f"no layout is called {brief(name, 100)}; allowed: {allowed}, or a file")
    return Layout(TEXTS[name].split())


def find_layout(name: str | os.PathLike[str]) -> Layout:
    """Return the layout in a file, or the layout with this name if there is no such file.

    Raises:
        LayoutError: the file is not a layout, or no layout has this name.
        OSError: the file cannot be read.
    """
    path = Path(name)
    if "\0" in str(name):
        raise LayoutError(f"no layout is called {brief(str(name))}: a name has no null character")
    if path.is_file() or path.suffix or len(path.parts) != 1:
        return load_layout(path)
    return named_layout(str(name))


def as_layout(layout: GivenLayout | None) -> Layout:
    """Return a layout given in any form of ``GivenLayout``; ``None`` is the chapter's layout.

    A string of several lines, or of tiles only, is the text of a layout. Any other string is a path
    or a name, see ``find_layout``.

    Raises:
        LayoutError: the value or its file is not a layout, or the file cannot be read.
        TypeError: the value has another type.
    """
    if layout is None:
        return DEFAULT_LAYOUT
    if isinstance(layout, Layout):
        return layout
    if not isinstance(layout, (str, os.PathLike)):
        return Layout(layout)
    not_text = ""
    if isinstance(layout, str):
        try:
            return Layout.from_text(layout)
        except LayoutError as error:
            if not layout or "\n" in layout:
                raise
            not_text = f"; nor is it the text of a layout: {error}"
    try:
        return find_layout(layout)
    except OSError as error:
        raise LayoutError(f"{os.fspath(layout):.200}: {error.strerror}{not_text}") from error
    except LayoutError as error:
        if Path(layout).exists():
            raise
        raise LayoutError(f"{error}{not_text}") from error
