"""The command ``warehouse race``: agents side by side, in the same layout and on one clock."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import Annotated, NamedTuple

import typer

from agents.errors import EpisodeInterrupted
from agents.lab.commands.compare_agents import AGENTS
from agents.lab.commands.worlds import (
    FRAME_SECONDS,
    ICE,
    ICY,
    on_one_clock,
    result_rows,
    split_worlds,
    world_sentences,
)
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.output import Film, show_or_save
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.console.values import with_slippery
from agents.lab.trials.task import Task, load_task
from agents.learning.q_learning import QAgent, QTable, learn
from agents.registry import make_agent
from warehouse_core import Agent, Episode, Layout, WarehouseEnv
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.task.starts import START
from warehouse_core.viz.tracks import record_track
from warehouse_core.viz.tracks.track import Track
from warehouse_core.world.actions import WAIT, action_index
from warehouse_core.world.named_layouts import BAY

LEARNER = "q"
"""Name of the agent that learns the layout by Q-learning before the race."""

RACERS = ("greedy:escape_steps=0", "greedy", "exploring", LEARNER, "astar")
"""Names of the agents that race by default."""

BLIND = "astar:replan=False"
"""Name of the agent that runs in several worlds by default, where its plan may fail."""

TITLES = AGENTS | {LEARNER: "Q-learning", BLIND: "A* without replanning"}

PRACTICE, MAX_PRACTICE = 500, 500_000
"""Steps of practice for each open cell of the layout, and the limit on all steps of practice."""

BATTERY = 200
"""Steps that a full battery lasts."""

CIRCLES = 3
"""Visits of a cell with the same load from which a robot is said to go in circles."""


class Race(NamedTuple):
    """A race: a table, a sentence for each racer, and a function that returns the tracks."""

    table: TextTable
    sentences: list[str]
    tracks: Callable[[], list[Track]]


def race(
    context: typer.Context,
    agent: Annotated[
        list[str] | None,
        option(
            "--agent NAME",
            f"{options.AGENT} {options.MAY_BE_REPEATED} {LEARNER} without a file learns the layout "
            f"before the race. Default: {', '.join(RACERS)}; with --worlds {BLIND}.",
            show_default=False,
        ),
    ] = None,
    worlds: Annotated[
        str | None,
        option(
            "--worlds NAME,NAME",
            "Let one agent run in several worlds instead: grid, physics, driving (a body drives "
            "the path of the grid in one go), icy (a body on wet ice with a grip of 0.05, "
            "everywhere or in the --slippery cells) or other backends.",
        ),
    ] = None,
    backend: options.BackendOption = "grid",
    layout: Annotated[Path, option("--layout FILE", options.LAYOUT)] = Path(BAY),
    seed: options.Seed = 35,
    max_steps: options.MaxSteps = 60,
    *,
    slippery: options.SlipperyOption,
    save: options.SaveReplay,
    show: options.Show = None,
    speed: options.Speed = 1.0,
) -> None:
    """Let agents race in the same layout.

    All agents start from the same cell at the same time, each in its own copy
    of the layout. The replay shows them on one clock, and says which of them
    wait, go in circles or have arrived. It is best watched as a page:
    --save race.html. With --worlds, one agent runs in several worlds.

    Example: warehouse race --worlds grid,physics,icy --save race.html
    """
    task = load_task(layout, battery=BATTERY, max_steps=max_steps, backend=backend)
    where = f"layout {layout.stem}"
    if worlds is None:
        [backend] = with_slippery(slippery, layout, backend)
        task = task._replace(backend=backend)
        shown = race_of_agents(agent or RACERS, task, seed, where)
    else:
        options.refuse(context, ["backend"], "race --worlds")
        [ice] = with_slippery(slippery, layout, ICE)
        shown = race_of_worlds(split_worlds(worlds), agent or [BLIND], ice, task, seed, where)
    print_table(shown.table)
    for sentence in shown.sentences:
        say(fill(sentence, get_terminal_size().columns))
    film = Film(shown.tracks, shown.table.title, speed=speed)
    show_or_save(film, save, show, f"race-{seed}.html")


def race_of_agents(agents: Sequence[str], task: Task, seed: int, where: str) -> Race:
    """Run agents on one backend."""
    records = {TITLES.get(name, name): run_racer(name, task, seed) for name in agents}
    columns = result_rows([*records.values()])
    rows = [*zip(records, *(values for _, *values in columns), strict=True)]
    title = f"Race on {where}, backend {task.backend}, seed {seed}"
    table = TextTable(("agent", *(name for name, *_ in columns)), rows, title)
    sentences = [f"{name}: {diagnose(record).sentence}." for name, record in records.items()]
    return Race(table, sentences, lambda: tracks_of(records))


def race_of_worlds(
    worlds: Sequence[str], agents: Sequence[str], ice: str, task: Task, seed: int, where: str
) -> Race:
    """Run an agent in several worlds; ``ice`` is the backend of the icy world."""
    if len(agents) != 1:
        raise typer.BadParameter(f"--agent is given {len(agents)} times; --worlds takes one agent")
    name = agents[0]
    records = {
        world: run_racer(name, task._replace(backend=ice if world == ICY else world), seed)
        for world in worlds
    }
    title = f"{TITLES.get(name, name)} on {where}, seed {seed}"
    return Race(
        TextTable(("", *records), result_rows([*records.values()]), title),
        world_sentences(records),
        lambda: on_one_clock(records, tracks_of(records, FRAME_SECONDS)),
    )


def run_racer(name: str, task: Task, seed: int) -> Episode:
    """Return the record of an episode of the agent with a name."""

    def make(name: str, seed: int, layout: Layout) -> Agent:
        if name == LEARNER:
            return practised(stations_of(task, seed), seed)
        return make_agent(name, seed, layout)

    try:
        return task.run(name, seed, make)
    except EpisodeInterrupted as error:
        raise typer.Abort from error


def stations_of(task: Task, seed: int) -> Layout:
    """Return the layout of the episode with a seed, with its stations."""
    with closing(task._replace(backend="grid").make_env(seed)) as env:
        env.reset(task.randomize, seed)
        layout: Layout = env.layout
    return layout


def practised(layout: Layout, seed: int) -> QAgent:
    """Return an agent that has learned on the grid to deliver from any cell of a layout."""
    table, steps = QTable(), min(PRACTICE * len(layout.open_cells), MAX_PRACTICE)
    for _ in learn(table, WarehouseEnv(layout, None), steps, seed, START):
        pass
    return QAgent(table, seed)


def tracks_of(
    records: Mapping[str, Episode], frame_seconds: float = record_track.FRAME_SECONDS
) -> list[Track]:
    """Return the tracks of records, with their titles and without charts."""
    tracks = []
    for title, record in records.items():
        track, states = (
            record_track.track_of_record(record, frame_seconds),
            ["", *states_of(record)],
        )
        track.title, track.metrics = title, {}
        for frame in track.frames[1:-1]:
            state = states[math.ceil(frame.progress)]
            frame.caption = f"{state}: {frame.caption}"
        tracks.append(track)
    return tracks


def states_of(record: Episode) -> Iterator[str]:
    """Yield for each step, in two or three words, what the robot is doing."""
    states = list(zip(record.cells, record.loaded, strict=True))
    visits = Counter(states[:1])
    for action, (before, here) in zip(record.actions, pairwise(states), strict=True):
        visits[here] += here != before
        if here == before and not record.is_driven:
            yield "waits" if action_index(action) == WAIT else "does not move"
        elif visits[here] >= CIRCLES:
            yield "goes in circles"
        else:
            yield "brings the item" if here[1] else "goes to the item"
