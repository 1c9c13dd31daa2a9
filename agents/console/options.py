"""What every command line of this project shares: one-line errors, exit codes, common options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.world import map_files as layout_files

MOST = 1_000_000_000
"""Of battery units and steps; a record keeps them as 64-bit numbers."""

AgentOption = Annotated[
    str,
    typer.Option(
        "--agent",
        help="greedy, exploring, bfs, ucs, astar, weighted-astar, greedy-best-first, ppo:FILE, "
        "q:FILE, or your own as file.py:Class.",
    ),
]

LayoutOption = Annotated[
    Path | None,
    typer.Option("--layout", metavar="FILE", help="Text file of # . P D rows, or MovingAI's .map."),
]

SeedOption = Annotated[
    int | None, typer.Option("--seed", metavar="N", help="Repeats a run; drawn if not given.")
]

BatteryOption = Annotated[
    int, typer.Option("--battery", min=1, max=MOST, help="Units of a full battery.")
]

MaxStepsOption = Annotated[
    int, typer.Option("--max-steps", min=1, max=MOST, help="Steps of an episode.")
]

BackendOption = Annotated[str, typer.Option("--backend", help="What carries out the moves.")]

SaveOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--save",
        metavar="FILE",
        help="Write .gif, .mp4, .html, .svg, .png or .npz; may be given more than once.",
    ),
]

ShowOption = Annotated[
    bool | None,
    typer.Option("--show/--no-show", help="Open a window. Default: where nothing is saved."),
]


def load_layout(path: Path | None) -> Layout:
    """Read a layout, a ``.map`` as MovingAI has it; without a path it is the chapter's."""
    return DEFAULT_LAYOUT if path is None else layout_files.load_layout(path)
