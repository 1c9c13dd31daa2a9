"""Run the exploring agent, and replay the world beside its belief."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from agents.console.options import (
    BackendOption,
    BatteryOption,
    LayoutOption,
    MaxStepsOption,
    SaveOption,
    SeedOption,
    ShowOption,
    load_layout,
)
from agents.console.output import show_or_save
from agents.run_episode import draw_seed, report_episode
from agents.search.agents import ExploringAgent
from warehouse_core import Episode, WarehouseEnv
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import fewest_steps

if TYPE_CHECKING:
    from agents.search.belief_replay import Insight

MAX_VIEW_RADIUS = 100
"""A window of this radius has 40,401 cells, which are read at every step."""


def explore(
    layout: LayoutOption = None,
    seed: SeedOption = None,
    backend: BackendOption = "grid",
    view_radius: Annotated[
        int,
        typer.Option(
            "--view-radius", min=0, max=MAX_VIEW_RADIUS, help="Cells seen in each direction."
        ),
    ] = 2,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    *,
    save: SaveOption,
    show: ShowOption = None,
) -> None:
    """Explore from a random start, and show the world beside what the agent believes of it."""
    from agents.search.belief_replay import belief_tracks, record_beliefs
    from warehouse_core.viz.replay import replay_of_track

    seed = draw_seed() if seed is None else seed
    env = WarehouseEnv(load_layout(layout), None, max_steps, battery, view_radius, backend=backend)
    agent = ExploringAgent()
    try:
        episode, history = record_beliefs(env, agent, seed=seed)
    finally:
        env.close()
    report_episode(episode)
    report_exploring(episode, history, agent.plans)
    show_or_save(
        lambda window: replay_of_track(*belief_tracks(episode, history), window=window),
        save,
        show,
        Path(f"explore-{seed}.gif"),
        episode,
    )


def report_exploring(episode: Episode, history: list[Insight], plans: int) -> None:
    """Print how many cells were seen and plans made, and compare the length with the shortest."""
    layout = episode.layout
    seen = sum(len(insight.seen) for insight in history)
    [fewest] = fewest_steps(layout, (episode.cells[0], episode.loaded[0]))
    typer.echo(f"cells seen      {seen} of {layout.height * layout.width}")
    typer.echo(f"plans made      {plans}")
    if fewest is None:
        typer.echo("fewest steps    none: no way leads to the delivery")
    elif episode.outcome == DELIVERED:
        typer.echo(f"fewest steps    {fewest}; it took {episode.steps / fewest:.2f} times as many")
    else:
        typer.echo(f"fewest steps    {fewest}")
