"""The command ``warehouse export``: results, episodes and datasets for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.lab.console import options
from agents.lab.console.options import RECORD_SUFFIX
from agents.lab.console.terminal import say
from agents.lab.datasets.recording import MCAP, save_recording
from agents.lab.datasets.table import save_table
from agents.lab.runs.run import draw_seed
from agents.lab.trials.task import load_task
from warehouse_core import Episode
from warehouse_core.files.atomic import check_suffix
from warehouse_core.wording import counted

CSV = ".csv"


def export(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="[FILE] TARGET",
            help="Results of 'warehouse sweep' are exported as .csv, an episode (.npz) as .mcap "
            "(needs the extra 'mcap'). Without FILE, TARGET is the name and version of a new "
            "Minari dataset, such as warehouse/astar-v0 (needs the extra 'minari').",
        ),
    ],
    agent: options.AgentOption = "greedy",
    backend: options.InstalledBackend = "grid",
    layout: options.LayoutOption = None,
    episodes: options.Episodes = 1000,
    seed: options.SeedOption = None,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    view_radius: options.ViewRadius = 2,
) -> None:
    """Write data for other programs.

    In a .csv table, each line is an episode with its settings, its outcome and the program that
    ran it. A recording (.mcap) has the layout, and over time the poses of robots and people,
    contacts and energy. Foxglove shows it in its 3D panel.

    A Minari dataset has whole episodes of an agent, for offline learning. It
    is written to the folder MINARI_DATASETS_PATH, or else to
    ~/.minari/datasets. All options belong to datasets.

    Example: warehouse export results.sqlite results.csv
    """
    if len(files) > 2:
        raise typer.BadParameter(
            f"{files[2]!r} is an unexpected argument; see: warehouse export -h"
        )
    if len(files) == 2:
        save_file(*map(Path, files))
        return
    from agents.lab.console.progress import track
    from agents.lab.datasets.minari_files import check_name, save_dataset
    from agents.lab.datasets.source import Source

    [name] = files
    check_name(name)
    first = draw_seed() if seed is None else seed
    seeds = range(first, first + episodes)
    limits = {"battery": battery, "max_steps": max_steps, "view_radius": view_radius}
    source = Source(agent, load_task(layout, None, None, backend=backend, **limits))
    recorded = source.episodes(seeds)
    folder = save_dataset(name, source, (next(recorded) for _ in track(seeds, "episodes")))
    say(f"saved {counted(len(seeds), 'episode')} as {name} in {folder}")


def save_file(source: Path, target: Path) -> None:
    """Write an episode as a recording, or results as a table.

    After an error there is no incomplete file.
    """
    if source.suffix.lower() == RECORD_SUFFIX:
        check_suffix(target, (MCAP,))
        save_recording(target, Episode.load(source))
    else:
        check_suffix(target, (CSV,))
        save_table(target, source)
    say(f"saved {target}")
