"""The command ``warehouse run``: episodes of one robot, their outcomes and a replay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import fmean
from typing import TYPE_CHECKING

import typer

from agents.errors import EpisodeError, EpisodeInterrupted
from agents.lab.commands.worlds import DRIVE_ROWS
from agents.lab.console import options
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say
from agents.lab.console.values import with_slippery
from agents.lab.place import Stations
from agents.lab.runs.run import draw_seed
from agents.lab.trials.task import Task, load_task
from agents.registry import make_agent
from agents.search.agents import ExploringAgent
from warehouse_core import (
    DEFAULT_LAYOUT,
    Agent,
    Cell,
    Episode,
    Layout,
)
from warehouse_core.records.drive_summary import drive_summary
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import diagnose

if TYPE_CHECKING:
    from agents.search.belief_replay import Insight
    from warehouse_core.viz.tracks.track import Track


def run_episode(
    agent: str = "greedy",
    backend: str = "grid",
    layout: Layout | None = None,
    seed: int | None = None,
    battery: int = 200,
    max_steps: int = 200,
    view_radius: int = 2,
    start_pos: Cell | None = None,
    randomize: bool | str = True,
) -> Episode:
    """Run one episode, by default from a random start, and return its record.

    Args:
        agent: name of an agent, see ``agents.registry.make_agent``.
        backend: name of a motion backend, see ``agents.registry.make_backend``.
        layout: layout; ``None`` is the default layout.
        seed: seed of the start, the backend and the agent. ``None`` is a random seed, which the
            record keeps.
        battery: units of a full battery, at least 1.
        max_steps: maximum steps of the episode, at least 1.
        view_radius: cells seen in each direction.
        start_pos: start cell if it is not random; ``None`` is the default start.
        randomize: choice of the random parts, see ``WarehouseEnv.reset``.

    Raises:
        ValueError: a name is unknown, or a number is out of range.
        EpisodeError: the agent failed.
        EpisodeInterrupted: Ctrl-C was pressed during the episode.

    Example:
        >>> from agents.run_episode import run_episode
        >>> run_episode("greedy", seed=12).outcome
        'delivered'
    """
    seed = draw_seed() if seed is None else seed
    place = layout or DEFAULT_LAYOUT
    task = Task(place, battery, max_steps, backend, start_pos, randomize, view_radius)
    return task.run(agent, seed)


def report_episode(episode: Episode, stations: Stations | None = None) -> None:
    """Print the outcome of an episode, and whether its stations were drawn or kept."""
    settings = episode.settings
    source = f", {stations.words}" if stations else ""
    say(f"{episode.agent} on the {settings.backend} backend, seed {episode.seed}{source}")
    diagnosis = diagnose(episode)
    mode = "" if diagnosis.mode == episode.outcome else f"{diagnosis.mode}: "
    rows = {
        "outcome": episode.outcome,
        "diagnosis": f"{mode}{diagnosis.sentence}",
        "total reward": f"{episode.total_reward:.2f}",
        "final battery": f"{episode.battery[-1]} of {settings.battery}",
        "episode length": f"{episode.steps} of at most {settings.max_steps} steps",
    }
    summary = drive_summary(episode)
    if summary is not None:
        rows |= {name: value(summary) for name, value in DRIVE_ROWS.items()}
    width = max(map(len, rows)) + 2
    for name, text in rows.items():
        say(f"{name:<{width}}{text}")


def run(
    agent: options.AgentOption = "greedy",
    backend: options.RunBackend = "grid",
    layout: options.LayoutOption = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    seed: options.SeedOption = None,
    episodes: options.Episodes = 1,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    view_radius: options.ViewRadius = 2,
    *,
    slippery: options.SlipperyOption,
    save: options.Save,
    show: options.Show = None,
    speed: options.Speed = 1.0,
) -> None:
    """Run episodes of one robot and replay one.

    Several episodes are printed with one line each and a summary; the first
    is replayed if you give --save or --show. The replay of the agent
    "exploring" shows the map that it has in mind next to the real one.

    Example: warehouse run --agent astar --seed 12 --save replay.gif
    """
    [backend] = with_slippery(slippery, layout, backend)
    limits = {"battery": battery, "max_steps": max_steps, "view_radius": view_radius}
    task = load_task(layout, stations, start, backend=backend, **limits)
    first = draw_seed() if seed is None else seed
    beliefs = list[Belief]()

    def make(name: str, seed: int, layout: Layout) -> Agent:
        acting = make_agent(name, seed, layout)
        if isinstance(acting, ExploringAgent):
            from agents.search.belief_replay import noted

            beliefs.append((acting, noted(acting, layout)))
        return acting

    def finish(episode: Episode, show: bool | None) -> None:
        report_episode(episode, task.stations)
        make_tracks = report_belief(episode, *beliefs[0]) if beliefs else None
        replay_or_save(episode, save, show, speed, make_tracks=make_tracks)

    def run_seed(seed: int) -> Episode:
        try:
            return task.run(agent, seed, make)
        except EpisodeError as error:
            if error.episode is not None:
                finish(error.episode, show)
            raise
        except EpisodeInterrupted as error:
            finish(error.episode, False)
            raise typer.Abort from error

    if episodes == 1:
        finish(run_seed(first), show)
        return
    finished = [run_and_report(run_seed, each) for each in range(first, first + episodes)]
    report_summary(finished)
    del beliefs[1:]
    if save or show:
        finish(finished[0], show)


Belief = tuple[ExploringAgent, "list[Insight]"]
"""An exploring agent, and what it knew in each step."""


def run_and_report(run_seed: Callable[[int], Episode], seed: int) -> Episode:
    """Run the episode of a seed, and print its outcome as one line."""
    episode = run_seed(seed)
    say(f"seed {seed}: {diagnose(episode).sentence}; total reward {episode.total_reward:.2f}")
    return episode


def report_summary(episodes: Sequence[Episode]) -> None:
    """Print how many of several episodes delivered, and their mean reward and length."""
    delivered = sum(episode.outcome == DELIVERED for episode in episodes)
    reward = fmean(episode.total_reward for episode in episodes)
    steps = fmean(episode.steps for episode in episodes)
    say(
        f"{delivered} of {len(episodes)} episodes delivered, "
        f"mean total reward {reward:.2f}, mean length {steps:.1f} steps"
    )


def report_belief(
    episode: Episode, agent: ExploringAgent, history: list[Insight]
) -> Callable[[], Sequence[Track]] | None:
    """Print how much an exploring agent saw, and return a function that makes its replay.

    Returns:
        the function, or ``None`` if the episode ended with an error.
    """
    from agents.search.belief_replay import belief_tracks

    seen, cells = sum(len(insight.seen) for insight in history), episode.layout
    say(f"cells seen      {seen} of {cells.height * cells.width}, plans made: {agent.plans}")
    if len(history) != episode.steps:  # the episode ended with an error
        return None
    return lambda: belief_tracks(episode, history)
