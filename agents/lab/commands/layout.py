"""The command ``warehouse layout``: print, check, make and convert layouts."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from agents.lab.console.options import SAVE, option
from agents.lab.console.terminal import say
from agents.lab.console.values import load_layout
from warehouse_core import Layout, LayoutError, random_layout, shelf_layout
from warehouse_core.world.generators import benchmark_warehouse
from warehouse_core.world.map_files import save_layout
from warehouse_core.world.named_layouts import NAMES

RANDOM: dict[str, float] = {"height": 10, "width": 16, "density": 0.2, "seed": 0}
SHELVES: dict[str, float] = {
    "rows": 2, "columns": 3, "length": 4, "depth": 1, "aisle": 1,
    "pickups": 1, "dropoffs": 1, "chargers": 0, "seed": 0,
}  # fmt: skip

BENCHMARK = re.compile("-".join([r"(\d{1,9})"] * 5), re.ASCII)
"""Sizes of a MovingAI warehouse; numbers with more digits are always too large."""


def layout(
    layouts: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[LAYOUT]...",
            help="A file (.txt, or .map in MovingAI's format), a name, or a generator. Generators: "
            f"random: with {', '.join(RANDOM)}; shelves: with {', '.join(SHELVES)}; and "
            "warehouse:C-R-L-W-A, as in MovingAI's benchmark, with C x R blocks of L x W cells and "
            "aisles of A cells. Default: all layouts that have a name.",
            show_default=False,
        ),
    ] = None,
    check: Annotated[
        bool,
        option(
            "--check",
            "Check that items can be delivered and chargers can be reached, and print one line.",
        ),
    ] = False,
    save: Annotated[
        Path | None,
        option("--save -o FILE", f"{SAVE} A .map file has MovingAI's format, without P, D and C."),
    ] = None,
) -> None:
    """Print, check, make or convert layouts.

    In a layout, # is a wall, . is floor, P is a pickup, D is a dropoff and C is a charger. All
    open cells of a generated layout are connected.

    Example: warehouse layout shelves:rows=3,aisle=2,chargers=4 -o shelves.txt
    """
    if save is not None and (not layouts or len(layouts) > 1):
        raise typer.BadParameter("--save needs exactly one layout")
    for name in layouts or NAMES:
        floor = make_layout(name)
        if check:
            say(check_layout(floor, name))
        elif save is not None:
            save_layout(floor, save)
            say(f"saved {save}")
        elif layouts:
            say(floor)
        else:
            say(f"{name}, {floor.height} x {floor.width}\n{floor}\n")


def make_layout(text: str) -> Layout:
    """Return the layout of a file, a name, or a generator with arguments.

    Raises:
        LayoutError: the text or the file does not describe a layout.
        OSError: the file cannot be read.
    """
    kind, colon, given = text.partition(":")
    if kind in GENERATORS and (colon or text not in NAMES):
        return GENERATORS[kind](given)
    return load_layout(Path(text))


def _random(given: str) -> Layout:
    numbers = _arguments("random", given, RANDOM)
    return random_layout(numbers["height"], numbers["width"], numbers["density"], numbers["seed"])


def _shelves(given: str) -> Layout:
    numbers = _arguments("shelves", given, SHELVES)
    blocks = [numbers.pop(name) for name in ("rows", "columns", "length", "depth")]
    return shelf_layout(*blocks, **numbers)


def _warehouse(given: str) -> Layout:
    sizes = BENCHMARK.fullmatch(given)
    if not sizes:
        raise LayoutError(
            f"{given!r} is not a warehouse; "
            "allowed: five whole numbers C-R-L-W-A, such as 10-20-10-2-1"
        )
    columns, rows, length, depth, aisle = map(int, sizes.groups())
    return benchmark_warehouse(columns, rows, length, depth, aisle)


GENERATORS: dict[str, Callable[[str], Layout]] = {
    "random": _random,
    "shelves": _shelves,
    "warehouse": _warehouse,
}
"""Generators of layouts by name, called with the text after the colon."""


def _arguments(kind: str, given: str, defaults: Mapping[str, float]) -> dict[str, Any]:
    """Return the defaults, updated with the arguments in a text such as ``rows=3,aisle=2``."""
    values: dict[str, Any] = dict(defaults)
    for part in filter(None, given.split(",")):
        name, _, text = part.partition("=")
        number = re.fullmatch(r"\d{1,9}" if name != "density" else r"\d{0,9}\.?\d{1,9}", text)
        if name not in defaults or number is None:
            raise LayoutError(
                f"{kind} has {part!r}; it must be NAME=NUMBER; allowed: {', '.join(defaults)}"
            )
        values[name] = float(text) if name == "density" else int(text)
    return values


def check_layout(layout: Layout, name: str) -> str:
    """Return one line that describes a layout in which items can be delivered.

    Raises:
        LayoutError: there is no pickup or no dropoff, or a station or charger cannot be reached.
    """
    for kind, stations in (("pickup P", layout.pickups), ("dropoff D", layout.dropoffs)):
        if not stations:
            raise LayoutError(f"{name}: there is no {kind}")
    first = layout.pickups[0]
    reached = layout.reachable_from(first)
    for station in layout.pickups + layout.dropoffs + layout.chargers:
        if station not in reached:
            raise LayoutError(
                f"{name}: {layout.describe(station)}, which cannot be reached from "
                f"the pickup at row {first[0]}, column {first[1]}"
            )
    chargers = f", chargers: {len(layout.chargers)}" if layout.chargers else ""
    cut_off = len(layout.open_cells) - len(reached)
    return (
        f"{name}: {layout.height} x {layout.width}, {len(layout.open_cells)} open cells "
        f"({cut_off} of them cut off), pickups: {len(layout.pickups)}, "
        f"dropoffs: {len(layout.dropoffs)}{chargers}; an item can be delivered"
    )
