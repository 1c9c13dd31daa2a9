"""Values from the texts of options: layouts, cells, batteries and fleet sizes.

A text that cannot be parsed raises ``typer.BadParameter``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import typer

from agents.code_names import split_name
from warehouse_core import DEFAULT_LAYOUT, Cell, Layout
from warehouse_core.arguments import MAX_STEPS
from warehouse_core.batch.fleet_settings import JOULES, STEPS
from warehouse_core.fleet import Battery
from warehouse_core.motion.backends import backend_names, load_backend
from warehouse_core.records.episode import is_drive
from warehouse_core.world.layout import check_open
from warehouse_core.world.named_layouts import find_layout


def load_layout(path: Path | None) -> Layout:
    """Return the layout with a name or in a file, or by default the layout of the chapter."""
    return DEFAULT_LAYOUT if path is None else find_layout(path)


def parse_cell(text: str | None, option: str) -> Cell | None:
    """Return the cell that a text ``ROW,COL`` names, or ``None`` for ``None``."""
    if text is None:
        return None
    cell = re.fullmatch(r"\s*(-?[0-9]{1,9})\s*,\s*(-?[0-9]{1,9})\s*", text)
    if cell is None:
        raise typer.BadParameter(f"{option} is {text!r}; it must be ROW,COL, as in 1,2")
    return int(cell[1]), int(cell[2])


def with_slippery(cells: Sequence[str], path: Path | None, *backends: str) -> list[str]:
    """Return the names of backends, with slippery cells for those that have bodies.

    Args:
        cells: texts ``ROW,COL``.
        path: name or file of the layout in which the cells must be open, see ``load_layout``.
        backends: names of the backends.

    Raises:
        LayoutError: a cell is a wall or outside the layout.
    """
    if cells and not any(map(_has_bodies, backends)):
        given = ", ".join(backends)
        raise typer.BadParameter(
            f"--slippery needs a backend with bodies; allowed: physics; given: {given}"
        )
    wet = [cell for text in cells if (cell := parse_cell(text, "--slippery"))]
    if wet:
        layout = load_layout(path)
        for cell in wet:
            check_open(layout, cell, "--slippery")
    setting = "slippery=" + "+".join(f"{row}-{col}" for row, col in wet)
    return [
        f"{each}{',' if ':' in each else ':'}{setting}" if wet and _has_bodies(each) else each
        for each in backends
    ]


def _has_bodies(backend: str) -> bool:
    name = split_name(backend).source
    return is_drive(backend) or (
        name in backend_names() and "slippery" in getattr(load_backend(name), "WORDS", ())
    )


def parse_battery(text: str) -> Battery:
    """Return the battery for a text such as ``400``, ``400steps`` or ``20000joules``."""
    battery = re.fullmatch(rf"([0-9]{{1,12}}) ?({STEPS}|{JOULES})?", text)
    if battery is None or not 1 <= int(battery[1]) <= MAX_STEPS:
        raise typer.BadParameter(
            f"--battery is {text!r}; it must be 1..{MAX_STEPS} steps or joules, as in 400steps"
        )
    return Battery(int(battery[1]), battery[2] or STEPS)


def parse_sizes(text: str) -> list[int]:
    """Return the fleet sizes from a text such as ``32,64``, in ascending order."""
    parts = [part.strip() for part in text.split(",")]
    for part in parts:
        if not (part.isascii() and part.isdecimal() and len(part) < 10 and int(part) > 0):
            raise typer.BadParameter(
                f"--robots has {part!r}; it must be whole numbers, at least 1, as in 32,64"
            )
    return sorted(set(map(int, parts)))
