"""What every command line of this project shares: one-line errors, exit codes, common options."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from agents.agent_error import AgentError
from agents.experiments.episodes import EpisodeError
from agents.experiments.setting import SettingError
from agents.experiments.store import StoreError
from agents.experiments.workers import ClusterError, WorkerError
from warehouse_core import (
    DEFAULT_LAYOUT,
    BackendError,
    Layout,
    LayoutError,
    RecordError,
    layout_files,
)
from warehouse_core.display import NoDisplayError
from warehouse_core.export import FormatError

USER_ERROR, INTERRUPTED = 1, 130

MOST = 1_000_000_000
"""Of battery units and steps; a record keeps them as 64-bit numbers."""

LONGEST = 2000
"""Characters of an error; a value that is named in it may be as long as a file."""

EXPECTED = (
    ClusterError,
    EpisodeError,
    SettingError,
    StoreError,
    WorkerError,
    AgentError,
    BackendError,
    FormatError,
    LayoutError,
    NoDisplayError,
    RecordError,
    OSError,
)
"""Errors of what the user gave. Everything else is a fault, and its traceback is wanted."""

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


def main(app: typer.Typer, arguments: Sequence[str] | None = None) -> None:
    """Run a command line and exit: 0 done, 1 a user's error, 2 wrong usage, 130 interrupted."""
    command = typer.main.get_command(app)
    try:
        code = command.main(arguments, standalone_mode=False)
    except TyperException as error:
        code = _fail(error.format_message(), error.exit_code)
    except EXPECTED as error:
        code = _fail(_describe(error), USER_ERROR)
    except (typer.Abort, KeyboardInterrupt):
        code = _fail("interrupted", INTERRUPTED)
    sys.exit(code)


def load_layout(path: Path | None) -> Layout:
    """Read a layout, a ``.map`` as MovingAI has it; without a path it is the chapter's."""
    return DEFAULT_LAYOUT if path is None else layout_files.load_layout(path)


def _fail(message: str, code: int) -> int:
    line = _in_a_line(message)
    if line:  # there is none where the help was all that was to be said
        typer.echo(f"warehouse: {line}", err=True)
    return code


def _in_a_line(message: str) -> str:
    """Return a message as one line that a terminal can show, whatever a file had put into it."""
    line = " ".join(message.split())
    if len(line) > LONGEST:
        line = f"{line[:LONGEST]}..."
    return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in line)


def _describe(error: Exception) -> str:
    if isinstance(error, BrokenPipeError):
        # Whoever reads our output has gone; keep the interpreter from complaining at its exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
