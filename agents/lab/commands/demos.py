"""The command ``warehouse demo``: short demonstrations of rigid bodies and fleets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from agents.fleet.planned import PlanLog, PlannedFleet
from agents.lab.console import options
from agents.lab.console.main import help_of
from agents.lab.console.output import Film, save_picture, show_or_save, unused
from agents.lab.console.terminal import say
from agents.lab.console.watch import slow_steps_reported
from agents.lab.runs.run import run
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.pibt import PIBT
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    Episode,
    EpisodeRecorder,
    FleetEnv,
    Layout,
    OrderStream,
    WarehouseEnv,
    record_episode,
)
from warehouse_core.files.atomic import check_suffix
from warehouse_core.motion.backends import load_backend
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted, seconds_of
from warehouse_core.world.named_layouts import DEPOT, find_layout

if TYPE_CHECKING:
    from warehouse_core.viz.figure import SceneFigure

CORRIDOR = Layout(["########", "#P....D#", "########"])
SLOW_MOTION = 0.025
"""Simulated seconds between frames in slow motion."""

HALL = Layout(["#######", "#.....#", "#.....#", "#.....#", "#######"])

SHELF_ROWS, SHELF_COLUMNS, SHELF, MARGIN = 5, 2, 8, 2
"""Rows and columns of shelves, their length, and the free cells on both sides of them."""

STATIONS = "PD.."
"""Tiles along shelves, repeated."""

ROBOTS, RATE, STEPS, BATTERY = 60, 6.0, 300, 10_000
"""Settings with which orders arrive faster than they are delivered, and no robot has to charge."""


class Demo(NamedTuple):
    """A demonstration: a sentence, and either a replay or a picture.

    Attributes:
        result: sentence about the result.
        tracks: tracks of a replay, shown side by side.
        draw: function that draws a picture, or ``None``.
    """

    result: str
    tracks: Sequence[Track] = ()
    draw: Callable[[], SceneFigure] | None = None


def bump() -> Demo:
    """A robot runs into a wall, in slow motion, with the impulse of the hit."""
    from warehouse_physics import RigidBodyMotion

    env = WarehouseEnv(HALL, (2, 1), backend=RigidBodyMotion(path_every=1))
    episode = drive(env, ["W"], "bump")
    contact = episode.motions[0].contacts[0]
    result = f"impulse of {contact.impulse:.1f} N·s at {contact.seconds:.2f} s"
    title = f"A bump in slow motion: {contact.impulse:.1f} N·s"
    track = track_of_record(episode, frame_seconds=SLOW_MOTION)
    track.metrics, track.ending = {}, ""
    return Demo(result, [_titled(track, title)])


def slip() -> Demo:
    """Actions that were planned on the grid fail on a slippery floor."""
    from warehouse_physics import Disturbances, RigidBodyMotion

    planned = record_episode(WarehouseEnv(CORRIDOR), GreedyAgent(seed=0), randomize=False)
    disturbances = Disturbances(slippery=frozenset({(1, 3), (1, 4)}))
    env = WarehouseEnv(CORRIDOR, backend=RigidBodyMotion(disturbances=disturbances))
    plan = [str(action) for action in planned.actions]
    slipped = drive(env, plan, "the same actions", seed=0)
    slipped_track = track_of_record(slipped)
    ended = f"the item is at {slipped.cells[-1]}"
    slipped_track.ending, slipped_track.frames[-1].caption = "not delivered", ended
    result = (
        f"the plan delivers in {planned.steps} steps on the grid; on the slippery floor {ended}"
    )
    plan_track = _titled(track_of_record(planned), "The plan on the grid")
    return Demo(
        result,
        [plan_track, _titled(slipped_track, "The same actions with columns 3 and 4 slippery")],
    )


def wheels() -> Demo:
    """A robot that moves in any direction and one with two wheels drive along the same path."""
    from warehouse_physics import RigidBodyMotion, RobotSpec

    titles = {
        "omnidirectional": "Moving in any direction",
        "differential": "Two wheels: turns take time and energy",
    }
    tracks, results = [], []
    for kind, title in titles.items():
        backend = RigidBodyMotion(RobotSpec(drive=kind), path_every=2)
        episode = drive(WarehouseEnv(HALL, (1, 1), backend=backend), [*"EESSWWN"], kind)
        track = _titled(track_of_record(episode), title)
        track.metrics, track.ending = {}, ""
        tracks.append(track)
        results.append(f"{kind}: {seconds_of(episode.seconds)} s and {episode.joules:.0f} J")
    return Demo("; ".join(results), tracks)


def pibt() -> Demo:
    """Robots planned by PIBT push others aside; three robots show their plans."""
    layout, log = find_layout(DEPOT), PlanLog([0, 1, 2], pushes=True)
    fleet = PlannedFleet(PIBT(Graph(layout)), "hungarian", log=log)
    episode = run_shift(fleet, "PIBT", layout, 30, 1.0, 60)
    pushes = sum(len(plans.pushers) for plans in log.plans)
    result = f"{counted(episode.robots, 'robot')} push {pushes} times in {episode.steps} steps"
    track = track_of_record(episode, plans=log.plans)
    track.metrics = {}
    return Demo(result, [_titled(track, f"PIBT: {result}; arrows show who pushes whom")])


def lanes() -> Demo:
    """Maps show where robots are held up, with and without one-way lanes."""
    layout, episodes = crowded_floor(), {}
    for name, costs in (("Without lanes", None), ("With lanes", lane_costs(layout))):
        fleet = PlannedFleet(PIBT(Graph(layout, costs), seed=1), "hungarian")
        episodes[name] = run_shift(fleet, name, layout, ROBOTS, RATE, STEPS)
    without, with_lanes = (episode.measures.per_hour for episode in episodes.values())
    result = (
        f"{without:,.0f} deliveries per hour without lanes, {with_lanes:,.0f} with lanes: "
        f"{with_lanes / without - 1:+.0%}"
    )

    def draw() -> SceneFigure:
        from warehouse_core.viz.axes.heat_map import congestion_picture
        from warehouse_core.viz.figure import make_figure

        title = f"{ROBOTS} robots planned by PIBT, with the same orders"
        return congestion_picture(episodes, title, make_figure)

    return Demo(result, draw=draw)


DEMOS: dict[str, Callable[[], Demo]] = {
    made.__name__: made for made in (bump, slip, wheels, pibt, lanes)
}

STILLS, BODIES = ("lanes",), ("bump", "slip", "wheels")
"""Demonstrations that are a picture, and those that need the physics backend."""


def drive(env: WarehouseEnv, actions: Sequence[str], name: str, seed: int | None = None) -> Episode:
    """Carry out actions from the start, and return the record.

    Actions after the end of the episode are ignored.
    """
    env.reset(seed=seed)
    recorder = EpisodeRecorder(env, seed=seed, agent=name)
    for action in actions:
        if not recorder.ended:
            recorder.step(action)
    env.close()
    return recorder.episode


def crowded_floor() -> Layout:
    """Return a layout with rows of shelves, aisles of one cell, and stations along the shelves."""
    tiles, ends = cycle(STATIONS), "." * MARGIN

    def row_of(tile: str) -> str:
        shelves = ("".join(tile or next(tiles) for _ in range(SHELF)) for _ in range(SHELF_COLUMNS))
        return f"{ends}{'.'.join(shelves)}{ends}"

    blocks = ((row_of(""), row_of("#"), row_of(""), row_of(".")) for _ in range(SHELF_ROWS))
    return Layout([row_of("."), *(row for block in blocks for row in block)])


def run_shift(
    fleet: PlannedFleet, name: str, layout: Layout, robots: int, rate: float, steps: int
) -> Episode:
    """Return the record of a shift with seed 1, in which no robot has to charge.

    ``rate`` is the mean number of orders that arrive in a step.
    """
    env = FleetEnv(
        layout, robots, orders=OrderStream(rate), max_steps=steps, battery=BATTERY, dispatch=False
    )
    return run(env, fleet, 1, slow_steps_reported(fleet, name), name=name)


def demo(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help=f"Name of a demonstration: {', '.join(DEMOS)}."),
    ] = None,
    *,
    save: options.SaveReplay,
    show: options.Show = None,
) -> None:
    """Show demonstrations of bodies and fleets.

    Without a name, the command lists the demonstrations. The demonstration
    "lanes" is a picture, which is saved as .svg or .png.

    Example: warehouse demo bump --save bump.gif
    """
    if name is None and not save:
        for each, make in DEMOS.items():
            say(f"{each:<10}{help_of(make).strip()}")
        return
    if name is None or name not in DEMOS:
        given = "--save needs a demonstration" if name is None else f"no demo is called {name!r}"
        raise typer.BadParameter(f"{given}; allowed: {', '.join(DEMOS)}")
    if name in STILLS:
        for path in save:
            check_suffix(path, options.PICTURES)
    if name in BODIES:
        load_backend("physics")
    shown = DEMOS[name]()
    say(shown.result)
    if shown.draw is None:
        show_or_save(Film(lambda: shown.tracks), save, show, f"demo-{name}.gif")
        return
    for path in save or [unused(Path(f"demo-{name}.png"))]:
        save_picture(shown.draw(), path)
        say(f"saved {path}")


def _titled(track: Track, title: str) -> Track:
    track.title = title
    return track
