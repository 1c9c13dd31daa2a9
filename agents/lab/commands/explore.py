"""Run the exploring agent, and replay its belief with the world beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from agents.lab.commands.run import report_episode
from agents.lab.console import options
from agents.lab.console.output import Film, show_or_save
from agents.lab.console.terminal import say
from agents.lab.console.values import load_place
from agents.lab.runs.run import draw_seed
from agents.registry import make_backend
from agents.search.agents import ExploringAgent
from warehouse_core import Episode, WarehouseEnv
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import fewest_steps

if TYPE_CHECKING:
    from agents.search.belief_replay import Insight


def explore(
    layout: options.LayoutOption = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    seed: options.SeedOption = None,
    backend: options.BackendOption = "grid",
    view_radius: options.ViewRadius = 2,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    *,
    save: options.Save,
    show: options.Show = None,
    still: options.Still = False,
) -> None:
    """Explore an unknown warehouse.

    The replay shows what the agent believes, and the world beside it.

    Example: warehouse explore --layout maze --view-radius 1
    """
    from agents.search.belief_replay import belief_tracks, record_beliefs

    seed = draw_seed() if seed is None else seed
    place = load_place(layout, stations, start)
    env = WarehouseEnv(
        place.layout,
        place.start_pos,
        max_steps,
        battery,
        view_radius,
        backend=make_backend(backend),
    )
    agent = ExploringAgent()
    try:
        episode, history = record_beliefs(env, agent, seed=seed, randomize=place.randomize)
    finally:
        env.close()
    report_episode(episode, place.stations)
    report_exploring(episode, history, agent.plans)
    film = Film(lambda: belief_tracks(episode, history), record=episode, still=still)
    show_or_save(film, save, show, f"explore-{env.backend}-{seed}.gif")


def report_exploring(episode: Episode, history: list[Insight], plans: int) -> None:
    """Print how many cells were seen and plans made, and compare the length with the shortest."""
    layout = episode.layout
    seen = sum(len(insight.seen) for insight in history)
    [fewest] = fewest_steps(layout, (episode.cells[0], episode.loaded[0]))
    say(f"cells seen      {seen} of {layout.height * layout.width}")
    say(f"plans made      {plans}")
    if fewest is None:
        say("fewest steps    none: no way leads to the delivery")
    elif episode.outcome == DELIVERED:
        say(f"fewest steps    {fewest}; it took {episode.steps / fewest:.2f} times as many")
    else:
        say(f"fewest steps    {fewest}")
