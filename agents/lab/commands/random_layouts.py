"""The options of commands for ``--layout random``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.lab.console.options import LAYOUT, option
from agents.lab.parameters import Whole
from agents.lab.parameters import size as check_size
from agents.lab.place import RANDOM
from agents.lab.trials.random_layouts import MAX_POOL, RandomLayouts
from warehouse_core.world.generators import MAX_DENSITY

DEFAULTS = RandomLayouts()

DENSITY = f"Share of walls inside the border, up to {MAX_DENSITY}."

LayoutOrRandom = Annotated[
    Path | None,
    option(
        "--layout FILE",
        f"{LAYOUT} Default: default, of the chapter. With {RANDOM}, another for each episode.",
    ),
]

SIZE = f"Rows and columns of random layouts. Default: {DEFAULTS.height}x{DEFAULTS.width}."
Sizes = Annotated[
    list[str] | None,
    option("--size HxW", f"{SIZE} May be repeated.", check_size, show_default=False),
]

Density = Annotated[
    str | None,
    option(
        "--density LOW:HIGH",
        f"{DENSITY} Default: {DEFAULTS.lowest}:{DEFAULTS.highest}, drawn for each.",
    ),
]

Pool = Annotated[
    int | None,
    option(
        "--layouts N",
        "Random layouts of the training; each episode is in one of them. "
        f"Default: {DEFAULTS.count}.",
        Whole(1, MAX_POOL),
        show_default=False,
    ),
]


def are_wanted(layout: Path | None, **options: object) -> bool:
    """Return whether ``--layout`` asks for random layouts, and refuse their options if not."""
    if layout == Path(RANDOM):
        return True
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"--{name} describes random layouts; add --layout {RANDOM}")
    return False


def parse(
    size: str | None, density: str | None, count: int | None = None, pool_seed: int = 1
) -> RandomLayouts:
    """Return random layouts as described by options; ``None`` is the default of each."""
    height, width = DEFAULTS.height, DEFAULTS.width
    lowest, highest = DEFAULTS.lowest, DEFAULTS.highest
    if size is not None:
        height, width = map(int, size.split("x"))
    if density is not None:
        try:
            ends = [float(end) for end in density.split(":")]
            lowest, highest = ends if len(ends) > 1 else ends * 2
        except ValueError:
            raise typer.BadParameter(
                f"--density is {density!r}; it must be LOW:HIGH as in 0.1:0.4, or one number"
            ) from None
    return RandomLayouts(height, width, lowest, highest, count or DEFAULTS.count, pool_seed)
