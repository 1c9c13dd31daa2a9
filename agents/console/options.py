"""The options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.files.atomic import check_suffix, check_target
from warehouse_core.world import map_files

MAX_COUNT = 1_000_000_000
"""The largest battery and number of steps; records keep them as 64-bit numbers."""

RECORD_SUFFIX = ".npz"


def _save_option(help_text: str, *also: str) -> Any:
    """Return an option for files that a replay is written to.

    Args:
        help_text: what the option does.
        also: suffixes that are allowed beside those of pictures.
    """

    def check(targets: list[Path]) -> list[Path]:
        """Raise ``FormatError`` or ``OSError`` if a file cannot be written."""
        for target in targets:
            from warehouse_core.viz.export import FORMATS

            check_suffix(target, (*FORMATS, *also))
            check_target(target)
        return targets

    return typer.Option(
        "--save",
        metavar="FILE",
        help=help_text,
        default_factory=list,
        show_default=False,
        callback=check,
    )


AgentOption = Annotated[
    str,
    typer.Option(
        "--agent",
        help="The agent: greedy, exploring, bfs, ucs, astar, weighted-astar, greedy-best-first, "
        "ppo:FILE, q:FILE, or your own as file.py:Class.",
    ),
]

LayoutOption = Annotated[
    Path | None,
    typer.Option(
        "--layout",
        metavar="FILE",
        help="Layout file: text rows of # . P D, or a MovingAI .map. Default: the built-in layout.",
    ),
]

SeedOption = Annotated[
    int | None, typer.Option("--seed", metavar="N", help="Random seed. Default: a random one.")
]

BatteryOption = Annotated[
    int, typer.Option("--battery", min=1, max=MAX_COUNT, help="Units of a full battery.")
]

MaxStepsOption = Annotated[
    int, typer.Option("--max-steps", min=1, max=MAX_COUNT, help="Maximum steps of an episode.")
]

BackendOption = Annotated[
    str, typer.Option("--backend", help="Motion backend, such as grid or physics.")
]

SaveOption = Annotated[
    list[Path],
    _save_option(
        "Write the replay as .gif, .mp4, .html, .svg or .png, or the record as .npz; "
        "may be given more than once.",
        RECORD_SUFFIX,
    ),
]

SaveReplayOption = Annotated[
    list[Path],
    _save_option(
        "Write the replay as .gif, .mp4, .html, .svg or .png; may be given more than once."
    ),
]

ShowOption = Annotated[
    bool | None,
    typer.Option(
        "--show/--no-show",
        help="Open a window, or do not. Default: open one if nothing is saved.",
    ),
]

IntervalOption = Annotated[
    float,
    typer.Option("--interval-ms", min=1, max=60_000, help="Milliseconds between frames."),
]

SpeedOption = Annotated[
    float, typer.Option("--speed", min=0.01, max=100, help="Factor on the playing speed.")
]

TrainingStepsOption = Annotated[
    int, typer.Option("--steps", metavar="N", min=1, max=MAX_COUNT, help="Minimum training steps.")
]

TrainingSeedOption = Annotated[
    int, typer.Option("--seed", metavar="N", min=0, max=2**32 - 1, help="Random seed.")
]

ModelOption = Annotated[
    Path, typer.Option("--output", "-o", metavar="FILE", help="Write the agent to this .npz file.")
]


def load_layout(path: Path | None) -> Layout:
    """Return the layout in a file, or the built-in one if ``path`` is ``None``."""
    return DEFAULT_LAYOUT if path is None else map_files.load_layout(path)
