"""Run one episode from a random start, print its outcome and replay it."""

from __future__ import annotations

import typer

from agents.errors import EpisodeError, EpisodeInterrupted
from agents.lab.console import options
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say
from agents.lab.console.values import greedy_with, load_place
from agents.lab.console.watch import slow_steps_told
from agents.lab.runs.run import draw_seed
from agents.lab.runs.run import run as run_agent
from agents.registry import make_agent, make_backend
from warehouse_core import DEFAULT_LAYOUT, Cell, Episode, Layout, WarehouseEnv
from warehouse_core.records.failure_modes import diagnose


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
        agent: name of an agent, see ``agents/registry.py``.
        backend: name of a motion backend, see ``make_backend`` there.
        layout: ``None`` for the built-in one.
        seed: seed of the start, the backend and the agent; ``None`` is a random one, which the
            record keeps.
        battery: units of a full battery, at least 1.
        max_steps: most steps of the episode, at least 1.
        view_radius: cells seen in each direction.
        start_pos: start if none is drawn; ``None`` is the usual one.
        randomize: choice of what is drawn, see ``WarehouseEnv.reset``.

    Raises:
        ValueError: an unknown name or a number out of range.
        EpisodeError: the agent failed.
        EpisodeInterrupted: Ctrl-C was pressed during the episode.

    Example:
        >>> from agents.run_episode import run_episode
        >>> run_episode("greedy", seed=12).outcome
        'delivered'
    """
    layout = layout or DEFAULT_LAYOUT
    motion = make_backend(backend)
    env = WarehouseEnv(layout, start_pos, max_steps, battery, view_radius, backend=motion)
    seed = draw_seed() if seed is None else seed
    try:
        acting = make_agent(agent, seed, layout)
        watch = slow_steps_told(acting, agent)
        return run_agent(env, acting, seed, watch, name=agent, randomize=randomize)
    finally:
        env.close()


def report_episode(episode: Episode, stations: str = "") -> None:
    """Print the outcome of an episode, and whether its stations are drawn or kept."""
    settings = episode.settings
    source = f", stations {stations}" if stations else ""
    say(f"{episode.agent} on the {settings.backend} backend, seed {episode.seed}{source}")
    diagnosis = diagnose(episode)
    mode = "" if diagnosis.mode == episode.outcome else f"{diagnosis.mode}: "
    say(f"outcome         {episode.outcome}")
    say(f"diagnosis       {mode}{diagnosis.sentence}")
    say(f"total reward    {episode.total_reward:.2f}")
    say(f"final battery   {episode.battery[-1]} of {settings.battery}")
    say(f"episode length  {episode.steps} of at most {settings.max_steps} steps")


def run(
    agent: options.AgentOption = "greedy",
    backend: options.BackendOption = "grid",
    layout: options.LayoutOption = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    seed: options.SeedOption = None,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    view_radius: options.ViewRadius = 2,
    memory: options.Memory = None,
    escape: options.Escape = None,
    *,
    save: options.Save,
    show: options.Show = None,
    still: options.Still = False,
    speed: options.Speed = 1.0,
) -> None:
    """Run one episode and replay it.

    Example: warehouse run --agent astar --seed 12 --save replay.gif
    """
    place = load_place(layout, stations, start)
    name = greedy_with(agent, memory, escape)

    def finish(episode: Episode, show: bool | None) -> None:
        report_episode(episode, place.stations)
        replay_or_save(episode, save, show, speed=speed, still=still)

    try:
        episode = run_episode(
            name,
            backend,
            seed=seed,
            battery=battery,
            max_steps=max_steps,
            view_radius=view_radius,
            **place._asdict(),
        )
    except EpisodeError as error:
        if error.episode is not None:
            finish(error.episode, show)
        raise
    except EpisodeInterrupted as error:
        finish(error.episode, False)
        raise typer.Abort from error
    finish(episode, show)
