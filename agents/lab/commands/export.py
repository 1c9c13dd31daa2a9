"""The command ``warehouse export``: results, episodes and datasets for other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from agents.fleet.planned import wants_dispatch
from agents.lab.console import options
from agents.lab.console.options import RECORD_SUFFIX, option
from agents.lab.console.terminal import say, warnings_printed
from agents.lab.console.values import load_layout, load_place
from agents.lab.datasets.recording import MCAP, save_recording
from agents.lab.datasets.table import CSV, PARQUET, save_table
from agents.lab.parameters import Whole
from agents.lab.runs.run import draw_seed
from agents.registry import make_fleet_agent, make_team
from warehouse_core import Episode, FleetEnv, Layout
from warehouse_core.files.atomic import check_suffix
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.wording import counted

if TYPE_CHECKING:
    from agents.lab.datasets.source import Source


def export(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="[FILE] TARGET",
            help="Results of 'warehouse sweep' as .csv or .parquet (needs the extra 'parquet'); "
            "an episode .npz as .mcap (needs the extra 'mcap'). Without FILE the name of a new "
            "dataset of Minari and its version, such as warehouse/astar-v0 (needs the extra "
            "'minari').",
        ),
    ],
    agent: options.AgentOption = "greedy",
    planner: Annotated[
        str | None,
        option("--planner NAME", f"{options.PLANNER} Its robots have orders."),
    ] = None,
    robots: Annotated[
        int, option("--robots -r N", f"{options.ROBOTS} Several have orders.", Whole(1, 1000))
    ] = 1,
    order_rate: options.OrderRate = 0.2,
    backend: options.InstalledBackend = "grid",
    layout: options.LayoutOption = None,
    episodes: options.Episodes = 1000,
    seed: options.SeedOption = None,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    view_radius: options.ViewRadius = 2,
) -> None:
    """Write data for other programs.

    In a table each line is an episode: its settings, its outcome and the program that ran it, a
    column each. A recording has the layout, the poses of all robots and people, contacts and
    energy over time; Foxglove shows it in its 3D panel.

    A dataset has whole episodes of --agent or --planner for offline learning,
    in the folder MINARI_DATASETS_PATH or in ~/.minari/datasets. The options
    are for datasets.

    Example: warehouse export results.sqlite results.csv
    """
    if len(files) > 2:
        raise typer.BadParameter(f"{files[2]!r} is one argument too many; see: warehouse export -h")
    if len(files) == 2:
        save_file(*map(Path, files))
        return
    from agents.lab.datasets.fleet import FleetSource
    from agents.lab.datasets.lone import LoneSource
    from agents.lab.datasets.minari_files import check_name

    [name] = files
    check_name(name)
    first = draw_seed() if seed is None else seed
    seeds = range(first, first + episodes)
    if robots == 1 and planner is None:
        place = load_place(layout, None, None)
        save_episodes(
            name, LoneSource(agent, place, backend, battery, max_steps, view_radius), seeds
        )
        return
    floor = load_layout(layout)
    make_one: Callable[[int], FleetAgent] = partial(make_team, agent, robots, layout=floor)
    if planner is not None:
        make_one = partial(_planned, planner, robots, floor)
    env = FleetEnv(
        floor,
        robots,
        backend=backend,
        orders=order_rate,
        max_steps=max_steps,
        battery=battery,
        view_radius=view_radius,
        dispatch=wants_dispatch(make_one(first)),
    )
    with closing(env), warnings_printed():
        save_episodes(name, FleetSource(planner or agent, make_one, env), seeds)


def save_file(source: Path, target: Path) -> None:
    """Write an episode as a recording, or results as a table, whole or not at all."""
    if source.suffix.lower() == RECORD_SUFFIX:
        check_suffix(target, (MCAP,))
        save_recording(target, Episode.load(source))
    else:
        save_table(target, source, check_suffix(target, (CSV, PARQUET)))
    say(f"saved {target}")


def save_episodes(name: str, source: Source, seeds: Sequence[int]) -> None:
    """Write the episodes of some seeds as a dataset, and show the progress."""
    from agents.lab.console.progress import track
    from agents.lab.datasets.minari_files import save_dataset

    recorded = source.episodes(seeds)
    folder = save_dataset(name, source, (next(recorded) for _ in track(seeds, "episodes")))
    say(f"saved {counted(len(seeds), 'episode')} as {name} in {folder}")


def _planned(planner: str, robots: int, layout: Layout, seed: int) -> FleetAgent:
    return make_fleet_agent(planner, None, seed, layout, robots)
