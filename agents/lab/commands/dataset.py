"""The command ``warehouse dataset``: episodes of an agent as data for offline learning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from agents.fleet.planned import wants_dispatch
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.terminal import say, warnings_printed
from agents.lab.console.values import load_layout, load_place
from agents.lab.parameters import Whole
from agents.lab.runs.run import draw_seed
from agents.registry import make_fleet_agent, make_team
from warehouse_core import FleetEnv, Layout
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.wording import counted

if TYPE_CHECKING:
    from agents.lab.datasets.source import Source


def dataset(
    save: Annotated[
        str,
        option(
            "--save -o NAME",
            f"{options.SAVE} Its name and version, as in warehouse/greedy-v0; by them "
            "minari.load_dataset finds it.",
        ),
    ],
    agent: options.AgentOption = "greedy",
    robots: Annotated[
        int, option("--robots -r N", f"{options.ROBOTS} Several have orders.", Whole(1, 1000))
    ] = 1,
    planner: Annotated[
        str | None,
        option("--planner NAME", f"{options.PLANNER} Its robots have orders."),
    ] = None,
    order_rate: options.OrderRate = 0.2,
    backend: Annotated[
        str,
        option(
            "--backend NAME",
            "Name of the motion backend. Allowed: grid, physics, or another that is installed.",
        ),
    ] = "grid",
    layout: options.LayoutOption = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    episodes: options.Episodes = 1000,
    seed: options.SeedOption = None,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    view_radius: options.ViewRadius = 2,
) -> None:
    """Write episodes for offline learning.

    They are a dataset of Minari: whole episodes, with masks of actions and what the motion did as
    infos, and a Croissant card, in the folder MINARI_DATASETS_PATH or in
    ~/.minari/datasets. A reset of Warehouse-v0 with the seed of an episode and
    its actions repeat it. The data of several robots is joint: actions [T, R],
    observations [T + 1, R, L]; "warehouse fleet --seed" shows the episode.

    Example: warehouse dataset -o warehouse/astar-v0 --agent astar -n 1000
    """
    from agents.lab.datasets.fleet import FleetSource
    from agents.lab.datasets.lone import LoneSource
    from agents.lab.datasets.minari_files import check_name

    check_name(save)
    first = draw_seed() if seed is None else seed
    seeds = range(first, first + episodes)
    if robots == 1 and planner is None:
        place = load_place(layout, stations, start)
        lone = LoneSource(agent, place, backend, battery, max_steps, view_radius)
        write(save, lone, seeds)
        return
    if stations is not None or start is not None:
        raise typer.BadParameter(
            "--stations and --start do not go with --robots and --planner: orders use the stations "
            "of the layout, and starts are drawn"
        )
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
        write(save, FleetSource(planner or agent, make_one, env), seeds)


def write(name: str, source: Source, seeds: Sequence[int]) -> None:
    """Write the episodes of some seeds as a dataset, and show how far it is."""
    from agents.lab.console.progress import track
    from agents.lab.datasets.minari_files import save_dataset

    recorded = source.episodes(seeds)
    folder = save_dataset(name, source, (next(recorded) for _ in track(seeds, "episodes")))
    say(f"saved {counted(len(seeds), 'episode')} as {name} in {folder}")


def _planned(planner: str, robots: int, layout: Layout, seed: int) -> FleetAgent:
    return make_fleet_agent(planner, None, seed, layout, robots)
