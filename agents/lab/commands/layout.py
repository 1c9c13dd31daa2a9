"""The commands ``warehouse layout``: generate, import, check and print layouts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import typer

from agents.lab.commands.random_layouts import DENSITY
from agents.lab.console import options
from agents.lab.console.group import CommandGroup
from agents.lab.console.options import option
from agents.lab.console.terminal import say
from agents.lab.console.values import load_layout
from agents.lab.parameters import Number, Whole
from warehouse_core import Layout, LayoutError, random_layout, shelf_layout
from warehouse_core.world.generators import MAX_DENSITY, benchmark_warehouse
from warehouse_core.world.map_files import load_map, save_layout
from warehouse_core.world.named_layouts import NAMES, named_layout
from warehouse_core.world.tiles import TILES

app = typer.Typer(
    cls=CommandGroup,
    no_args_is_help=True,
    help="Make, import, check and print layouts. "
    f"They are rows of {', '.join(f'{tile} {name}' for tile, name in TILES.items())}.",
)

PLACE = "A layout file, or the name of a layout."

BENCHMARK = re.compile("-".join([r"(\d{1,9})"] * 5), re.ASCII)
"""Sizes with more digits are always too large."""


def count(name: str, help_text: str) -> Any:
    """Return the option of a whole number from 0."""
    return option(f"{name} N", help_text, Whole(0))


LayoutFile = Annotated[
    Path | None,
    option(
        "--save -o FILE",
        f"{options.SAVE} A .map has MovingAI's format, without P, D and C.",
    ),
]


@app.command()
def generate(
    height: Annotated[int, count("--height", "Rows, including the border.")] = 10,
    width: Annotated[int, count("--width", "Columns, including the border.")] = 16,
    density: Annotated[float, option("--density X", DENSITY, Number(0, MAX_DENSITY))] = 0.2,
    seed: options.Seed = 0,
    save: LayoutFile = None,
) -> None:
    """Make a layout of random walls.

    Every open cell can be reached.

    Example: warehouse layout generate --density 0.3 --seed 7 -o hall.txt
    """
    _print_or_save(random_layout(height, width, density, seed), save)


@app.command()
def shelves(
    rows: Annotated[int, count("--rows", "Shelf blocks from top to bottom.")] = 2,
    columns: Annotated[int, count("--columns", "Shelf blocks from left to right.")] = 3,
    length: Annotated[int, count("--length", "Cells of a block from left to right.")] = 4,
    depth: Annotated[int, count("--depth", "Cells of a block from top to bottom.")] = 1,
    aisle: Annotated[int, count("--aisle", "Cells between blocks.")] = 1,
    pickups: Annotated[int, count("--pickups", "Pickups P, above shelves.")] = 1,
    dropoffs: Annotated[int, count("--dropoffs", "Dropoffs D, on the bottom aisle.")] = 1,
    chargers: Annotated[int, count("--chargers", "Chargers C, at the left and right border.")] = 0,
    seed: options.Seed = 0,
    save: LayoutFile = None,
) -> None:
    """Make a layout of shelves and aisles.

    Example: warehouse layout shelves --rows 3 --aisle 2 --chargers 4 -o shelves.txt
    """
    stations = {"pickups": pickups, "dropoffs": dropoffs, "chargers": chargers}
    _print_or_save(shelf_layout(rows, columns, length, depth, aisle, seed, **stations), save)


@app.command()
def warehouse(
    name: Annotated[
        str, typer.Argument(metavar="C-R-L-W-A", help="Blocks C x R of L x W cells, aisles of A.")
    ],
    save: LayoutFile = None,
) -> None:
    """Make a warehouse of the benchmarks.

    The benchmarks are MovingAI's, of multi-agent path finding.

    Example: warehouse layout warehouse 10-20-10-2-1 -o large.map
    """
    sizes = BENCHMARK.fullmatch(name)
    if not sizes:
        raise LayoutError(
            f"{name!r} is not a warehouse; "
            "allowed: five whole numbers C-R-L-W-A, such as 10-20-10-2-1"
        )
    columns, rows, length, depth, aisle = map(int, sizes.groups())
    _print_or_save(benchmark_warehouse(columns, rows, length, depth, aisle), save)


@app.command("import")
def import_map(
    file: Annotated[Path, typer.Argument(metavar="FILE.map", help="A map in MovingAI's format.")],
    save: LayoutFile = None,
) -> None:
    """Read a map in MovingAI's format.

    Example: warehouse layout import den312d.map -o den.txt
    """
    _print_or_save(load_map(file), save)


@app.command()
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help=PLACE)],
) -> None:
    """Check that items can be delivered.

    Chargers must be within reach too.

    Example: warehouse layout check hall.txt
    """
    layout = load_layout(file)
    for name, stations in (("pickup P", layout.pickups), ("dropoff D", layout.dropoffs)):
        if not stations:
            raise LayoutError(f"{file}: there is no {name}")
    first = layout.pickups[0]
    reached = layout.reachable_from(first)
    for station in layout.pickups + layout.dropoffs + layout.chargers:
        if station not in reached:
            raise LayoutError(
                f"{file}: {layout.describe(station)}, which cannot be reached from "
                f"the pickup at row {first[0]}, column {first[1]}"
            )
    chargers = f", chargers: {len(layout.chargers)}" if layout.chargers else ""
    cut_off = len(layout.open_cells) - len(reached)
    say(
        f"{file}: {layout.height} x {layout.width}, {len(layout.open_cells)} open cells "
        f"({cut_off} of them cut off), pickups: {len(layout.pickups)}, "
        f"dropoffs: {len(layout.dropoffs)}{chargers}; an item can be delivered"
    )


@app.command("list")
def list_layouts() -> None:
    """Print the layouts that have a name.

    Example: warehouse layout list
    """
    for name in NAMES:
        layout = named_layout(name)
        say(f"{name}, {layout.height} x {layout.width}\n{layout}\n")


@app.command("print")
def print_layout(
    file: Annotated[Path | None, typer.Argument(metavar="FILE", help=PLACE)] = None,
) -> None:
    """Print a layout.

    Without a file it is the built-in one.

    Example: warehouse layout print trap
    """
    say(load_layout(file))


def _print_or_save(layout: Layout, path: Path | None) -> None:
    if path is None:
        say(layout)
    else:
        save_layout(layout, path)
        say(f"saved {path}")
