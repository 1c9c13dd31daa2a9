"""The command ``warehouse export``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.lab.commands.export.recording import MCAP, save_recording
from agents.lab.commands.export.table import CSV, PARQUET, save_table
from agents.lab.console.options import RECORD_SUFFIX
from agents.lab.console.terminal import say
from warehouse_core import Episode
from warehouse_core.files.atomic import check_suffix


def export(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Results of 'warehouse sweep', or an episode saved as .npz."
        ),
    ],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="TARGET",
            help="The file to write: results as .csv or .parquet (needs the extra 'parquet'), "
            "an episode as .mcap (needs the extra 'mcap').",
        ),
    ],
) -> None:
    """Write results for other programs.

    In a table each line is an episode: its settings, its outcome and the program that ran it, a
    column each. A recording has the layout, the poses of all robots and people, contacts and
    energy over time; Foxglove shows it in its 3D panel.

    Example: warehouse export results.sqlite results.csv
    """
    if source.suffix.lower() == RECORD_SUFFIX:
        check_suffix(target, (MCAP,))
        save_recording(target, Episode.load(source))
    else:
        save_table(target, source, check_suffix(target, (CSV, PARQUET)))
    say(f"saved {target}")
