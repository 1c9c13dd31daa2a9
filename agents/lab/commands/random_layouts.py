"""Options of commands for random layouts, which ``--layout random`` selects."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.lab.console.options import LAYOUT, option
from agents.lab.parameters import Whole, pair_of
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
        f"{LAYOUT} Default: default, the chapter's layout. {RANDOM} uses another random layout in "
        "each episode.",
    ),
]

SIZE = f"Height and width of random layouts. Default: {DEFAULTS.height}x{DEFAULTS.width}."
Sizes = Annotated[
    list[str] | None,
    option("--size HxW", f"{SIZE} May be repeated.", check_size, show_default=False),
]

Density = Annotated[
    str | None,
    option(
        "--density LOW:HIGH",
        f"{DENSITY} It is random for each layout. Default: {DEFAULTS.lowest}:{DEFAULTS.highest}.",
    ),
]

Pool = Annotated[
    int | None,
    option(
        "--layouts N",
        "Number of random layouts for training; each episode takes place in one of them. "
        f"Default: {DEFAULTS.count}.",
        Whole(1, MAX_POOL),
        show_default=False,
    ),
]


def are_wanted(layout: Path | None, **options: object) -> bool:
    """Return whether ``--layout`` asks for random layouts.

    Raises:
        typer.BadParameter: it does not, but an option for random layouts is given.
    """
    if layout == Path(RANDOM):
        return True
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"--{name} describes random layouts; add --layout {RANDOM}")
    return False


def parse(
    size: str | None,
    density: str | None,
    count: int | None = None,
    pool_seed: int = 1,
    default: RandomLayouts = DEFAULTS,
) -> RandomLayouts:
    """Return the random layouts that some options describe; ``None`` stands for the default."""
    height, width = pair_of(size) if size else (default.height, default.width)
    lowest, highest = default.lowest, default.highest
    if density is not None:
        try:
            ends = [float(end) for end in density.split(":")]
            lowest, highest = ends if len(ends) > 1 else ends * 2
        except ValueError:
            raise typer.BadParameter(
                f"--density is {density!r}; it must be LOW:HIGH as in 0.1:0.4, or one number"
            ) from None
    count = count or default.count
    return type(default)(height, width, lowest, highest, count, pool_seed)
