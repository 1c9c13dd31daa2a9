"""The options of commands for ``--layout random``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from agents.lab.console.options import LAYOUT, option
from agents.lab.place import RANDOM
from agents.lab.trials.random_layouts import MAX_POOL, RandomLayouts

DEFAULTS = RandomLayouts()

LayoutOrRandom = Annotated[
    Path | None,
    option("--layout FILE", f"{LAYOUT} With {RANDOM} each episode has a layout of its own."),
]

SIZE = f"Of random layouts, border included. Default: {DEFAULTS.height}x{DEFAULTS.width}."
Size = Annotated[str | None, option("--size HxW", SIZE)]
Sizes = Annotated[
    list[str] | None, option("--size HxW", f"{SIZE} May be repeated.", show_default=False)
]

Density = Annotated[
    str | None,
    option(
        "--density LOW:HIGH",
        "Share of walls in random layouts, up to 0.4. "
        f"Default: {DEFAULTS.lowest}:{DEFAULTS.highest}.",
    ),
]

Pool = Annotated[
    int | None,
    option(
        "--layouts N",
        "Random layouts of the training; each episode is in one of them. "
        f"Default: {DEFAULTS.count}.",
        (1, MAX_POOL),
        show_default=False,
    ),
]


def are_wanted(layout: Path | None, **options: object) -> bool:
    """Return whether ``--layout`` asks for random layouts, and refuse their options if not."""
    if layout == Path(RANDOM):
        return True
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"--{name} is of random layouts; add --layout {RANDOM}")
    return False


def parse(
    size: str | None, density: str | None, count: int | None = None, pool_seed: int = 1
) -> RandomLayouts:
    """Return random layouts as described by options; ``None`` is the default of each."""
    height, width = DEFAULTS.height, DEFAULTS.width
    lowest, highest = DEFAULTS.lowest, DEFAULTS.highest
    if size is not None:
        sides = re.fullmatch(r"([0-9]{1,9})x([0-9]{1,9})", size)
        if sides is None:
            raise typer.BadParameter(f"--size is {size!r}; it must be HxW as in 7x12")
        height, width = map(int, sides.groups())
    if density is not None:
        try:
            ends = [float(end) for end in density.split(":")]
            lowest, highest = ends if len(ends) > 1 else ends * 2
        except ValueError:
            raise typer.BadParameter(
                f"--density is {density!r}; it must be LOW:HIGH as in 0.1:0.4, or one number"
            ) from None
    return RandomLayouts(height, width, lowest, highest, count or DEFAULTS.count, pool_seed)
