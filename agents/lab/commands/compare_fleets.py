"""Comparison of a fleet in four worlds, for ``warehouse compare backends --robots N``.

The worlds are the plan on the grid, rigid bodies that stop in every cell, bodies that drive through
cells, and such bodies with disturbances. In all worlds, orders are released and due at the same
times in seconds.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import typer

from agents.errors import EpisodeError
from agents.fleet.planned import PlannedFleet, wants_dispatch
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.watch import slow_steps_reported
from agents.lab.parameters import Number
from agents.lab.runs.run import run
from agents.lab.trials.interval import MIN_VALUES, Interval, above_interval, mean_interval
from agents.lab.trials.workers import run_trials
from agents.registry import make_fleet_agent
from warehouse_core import (
    Cell,
    FleetEnv,
    FleetEpisode,
    Layout,
    LayoutError,
    Order,
    Outcome,
    WarehouseError,
)
from warehouse_core.batch.tally import SECONDS_PER_HOUR
from warehouse_core.files.tables import write_table
from warehouse_core.fleet import Battery
from warehouse_core.motion.backends import load_backend
from warehouse_core.motion.base import Motion
from warehouse_core.motion.grid import NOMINAL_SECONDS
from warehouse_core.wording import counted, listed
from warehouse_core.world.named_layouts import DEPOT, find_layout

PLAN, STOPPING, DRIVING, DISTURBED = WORLDS = (
    "grid plan",
    "stopping",
    "driving through",
    "disturbed",
)

STEPS_OF_A_CELL = 4
"""Number of steps in which a robot crosses a cell if it drives through.

With a single step, paths would be extended no faster than they are driven. Robots would then learn
of corners too late, and robots that have come to rest would wait for the next step.
"""

BATTERY, DUE = Battery(30_000, "joules"), (100, 300)
"""Battery of the robots, and minimum and maximum seconds from release to due time of an order.

A charger supplies the same power in all worlds.
"""

MAX_SECONDS = 600.0
"""Seconds allowed for each order of a robot after the last due time; longer runs are ended."""

PAGE, DISTURBANCES = ".html", "0.05:60"

FRAME_SECONDS, SPEED, HEIGHT = 0.5, 2.0, 860
"""Simulated seconds per frame of the replay, its playing speed, and its height in pixels."""


@dataclass(frozen=True)
class Setting:
    """The fleet, layout and orders that all worlds share.

    Attributes:
        layout: layout.
        robots: number of robots.
        planner: name of the planner.
        rate: mean number of orders that are released per second.
        count: number of orders in an episode.
        noise: standard deviation of disturbed speeds as a share of the commanded speeds.
        stop: seconds for which one disturbed robot stops; with 0 no robot stops, and with inf it
            stops forever.
    """

    layout: Layout
    robots: int
    planner: str
    rate: float
    count: int
    noise: float
    stop: float


class TimedOrder(NamedTuple):
    """An order to bring an item from a pickup to a dropoff; times are seconds after the reset."""

    released: float
    due: float
    pickup: Cell
    dropoff: Cell


class World(NamedTuple):
    """A factory for the motion of a fleet, and the nominal duration of a step in seconds."""

    motion: Callable[[], Motion]
    step_seconds: float


class Score(NamedTuple):
    """The measures of a run, with times by the clock of its world.

    Attributes:
        per_hour: deliveries per hour until the last delivery.
        on_time: share of all orders that were delivered by their due times.
        joules: energy of all robots per delivery.
        hits: number of contacts; two robots that touch have one contact.
        makespan: seconds until the last delivery.
        delivered: number of delivered orders.
        lost: number of robots with a flat battery or a defect.
        late_plans: number of steps in which all robots waited for a plan.
    """

    per_hour: float
    on_time: float
    joules: float
    hits: int
    makespan: float
    delivered: int
    lost: int
    late_plans: int


def draw_orders(setting: Setting, seed: int) -> list[TimedOrder]:
    """Return the first orders of a Poisson process, in order of release.

    Stations and times from release to due time are random, with uniform distributions.
    """
    layout, count, stream = setting.layout, setting.count, np.random.default_rng(seed)
    for kind, places in (("pickup", layout.pickups), ("dropoff", layout.dropoffs)):
        if not places:
            raise LayoutError(f"the layout has no {kind}, so that it cannot have orders")
    released = stream.exponential(1 / setting.rate, count).cumsum()
    dues = released + stream.uniform(*DUE, count)
    pickups, dropoffs = (
        [places[number] for number in stream.integers(len(places), size=count)]
        for places in (layout.pickups, layout.dropoffs)
    )
    return list(map(TimedOrder, released.tolist(), dues.tolist(), pickups, dropoffs))


def in_steps(orders: Sequence[TimedOrder], seconds: float) -> list[Order]:
    """Convert orders to the steps of a fleet, given the seconds of a step.

    Releases are rounded up and due times down. No order is due before it is released.
    """
    releases = [math.ceil(order.released / seconds) for order in orders]
    return [
        Order(released, max(math.floor(order.due / seconds), released), *order[2:])
        for released, order in zip(releases, orders, strict=True)
    ]


def make_world(name: str, setting: Setting, busy_seconds: float, seed: int) -> World:
    """Return the world with a name.

    A step on the grid lasts as long as crossing a cell at top speed. Robots that drive through
    cross a cell in ``STEPS_OF_A_CELL`` steps. If all robots stop in every cell, a step lasts until
    a loaded robot is at rest. With disturbances, one robot stops at a random time in the first half
    of ``busy_seconds``, in which orders are released.
    """
    if name == PLAN:
        return World(load_backend("grid"), NOMINAL_SECONDS)
    if name == STOPPING:
        stopping: Any = load_backend("physics")
        return World(stopping, stopping().spec.move_seconds(loaded=True))
    driving: Any = load_backend("driving")
    period = driving().period / STEPS_OF_A_CELL
    if name == DRIVING:
        return World(partial(driving, period=period), period)
    from warehouse_physics import Disturbances, Stop  # here, because it loads pymunk

    stream = np.random.default_rng(seed)
    robot, at = int(stream.integers(setting.robots)), float(stream.uniform(0, busy_seconds / 2))
    stops = (Stop(robot, at, setting.stop),) if setting.stop else ()
    shocks = Disturbances(actuation_noise=setting.noise, stops=stops)
    return World(partial(driving, disturbances=shocks, period=period), period)


def make_env(
    setting: Setting, world: World, orders: Sequence[TimedOrder], dispatch: bool = True
) -> FleetEnv:
    """Return the environment of a setting in a world.

    Raises:
        ValueError: it cannot be made; the message gives the reason.
    """
    motion = world.motion()
    charge = BATTERY.step_charge(motion.cell_size) * world.step_seconds
    seconds = max(order.due for order in orders)
    seconds += MAX_SECONDS * math.ceil(len(orders) / setting.robots)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about batteries that would not last for the episode
        return FleetEnv(
            setting.layout,
            setting.robots,
            backend=motion,
            orders=in_steps(orders, world.step_seconds),
            max_steps=math.ceil(seconds / world.step_seconds),
            battery=replace(BATTERY, charge=max(round(charge), 1)),
            dispatch=dispatch,
        )


def run_trial(
    world: str, seed: int, *, setting: Setting, kept: int | None = None
) -> tuple[Score, FleetEpisode | None]:
    """Run a fleet until all orders are delivered.

    Returns:
        Measures, and the record of the run if its seed is ``kept``.
    """
    orders = draw_orders(setting, seed)
    made = make_world(world, setting, orders[-1].released, seed)
    agent = make_fleet_agent(setting.planner, None, seed, setting.layout, setting.robots)
    watch = slow_steps_reported(agent, setting.planner)
    with closing(make_env(setting, made, orders, wants_dispatch(agent))) as env:
        try:
            record = run(env, agent, seed, watch, name=setting.planner)
        except EpisodeError as error:
            # Without its record, which would be sent from process to process.
            raise EpisodeError(f"world {world}, {error}") from None
    late_plans = len(agent.lost) if isinstance(agent, PlannedFleet) else 0
    return score_of(record, orders, late_plans), record if seed == kept else None


def score_of(record: FleetEpisode, orders: Sequence[TimedOrder], late_plans: int) -> Score:
    """Return the measures of a record, whose orders correspond to ``orders`` one by one."""
    steps = record.seconds.max(axis=1)
    # A drop that takes longer than the step in which it begins ends after this step.
    clock = np.append(0.0, steps.cumsum() + np.maximum(NOMINAL_SECONDS - steps, 0.0))
    times = [
        clock[done.delivered] if done.delivered is not None else math.inf for done in record.orders
    ]
    on_time = sum(time <= order.due for time, order in zip(times, orders, strict=False))
    ends = [time for time in times if time < math.inf]
    delivered, makespan = len(ends), max(ends, default=float(clock[-1]))
    each = max(delivered, 1)
    return Score(
        per_hour=delivered / makespan * SECONDS_PER_HOUR,
        on_time=on_time / len(orders),
        joules=float(record.joules.sum()) / each,
        hits=count_hits(record.motions),
        makespan=float(makespan),
        delivered=delivered,
        lost=record.measures.stranded,
        late_plans=late_plans,
    )


def count_hits(steps: Iterable[Sequence[Outcome]]) -> int:
    """Return the number of contacts; two robots that touch have one contact in common."""
    found = {
        (step, contact.seconds, frozenset((f"robot {robot}", contact.counterpart)))
        for step, outcomes in enumerate(steps)
        for robot, outcome in enumerate(outcomes)
        for contact in outcome.contacts
    }
    return len(found)


SeedScores = Mapping[str, Sequence[Score]]
"""Measures of each run by world; all worlds have the same seeds in the same order."""

Value = Callable[[Score, Score], float]
"""Function that returns a value of a run, given the run and the grid plan with the same seed."""

MEASURES: dict[str, Value] = {
    "deliveries per hour": lambda score, _: score.per_hour,
    "% of the plan": lambda score, plan: (
        100 * score.per_hour / plan.per_hour if plan.per_hour else math.nan
    ),
    "% on time": lambda score, _: 100 * score.on_time,
    "kJ per delivery": lambda score, _: score.joules / 1000,
    "last delivery (s)": lambda score, _: score.makespan,
    "hits": lambda score, _: score.hits,
}


def compare_fleets(
    robots: str,
    planner: str = "pibt:guidance=lanes",
    order_rate: float = 0.4,
    count: int = 40,
    layout: Path = Path(DEPOT),
    disturbed: str = DISTURBANCES,
    episodes: int = 4,
    seed: int = 0,
    jobs: int | None = None,
    save: Sequence[Path] = (),
) -> None:
    """Run the same fleet, orders and planner in all worlds, and print their measures and losses.

    An episode ends when all orders are delivered. Here ``order_rate`` is the mean number of orders
    per second.
    """
    if not robots.isdecimal():
        raise typer.BadParameter(f"--robots is {robots!r}; it must be one whole number")
    if not order_rate:
        raise typer.BadParameter("--order-rate is 0; allowed: a number above 0")
    noise, stop = parse_disturbed(disturbed)
    setting = Setting(find_layout(layout), int(robots), planner, order_rate, count, noise, stop)
    check(setting, seed)
    seeds = range(seed, seed + episodes)
    needs_record = any(path.suffix.lower() == PAGE for path in save)
    call = partial(run_trial, setting=setting, kept=seed if needs_record else None)
    results = run_trials(call, WORLDS, seeds, jobs)
    scores = {world: [score for score, _ in runs] for world, runs in results.items()}
    which = f"seed {seed}" if episodes == 1 else f"seeds {seed} to {seeds[-1]}"
    title = (
        f"{counted(setting.robots, 'robot')} ({planner}), {counted(count, 'order')} at "
        f"{order_rate:g} per second, layout {layout.stem}, disturbed: noise of {noise:.0%} and a "
        f"stop of {stop:g} s, {which}"
    )
    table = table_of(scores, title)
    # Files first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        if path.suffix.lower() == PAGE:
            kept = {world: runs[0][1] for world, runs in results.items()}
            write_page(path, table, {world: each for world, each in kept.items() if each})
        else:
            write_values(path, scores, seeds)
    print_table(table)
    for loss in losses(scores, count):
        print_error(f"warning: {loss}")
    for path in save:
        say(f"saved {path}")


def parse_disturbed(text: str) -> tuple[float, float]:
    """Return the noise and the seconds of a stop in a text ``NOISE:SECONDS``."""
    try:
        noise, stop = map(float, text.split(":"))
        Number(0, 0.5)(noise)
        Number(0, math.inf)(stop)
    except ValueError:
        needed = f"a share 0..0.5 and seconds, such as {DISTURBANCES}"
        raise typer.BadParameter(f"--disturbed is {text!r}; it must be {needed}") from None
    return noise, stop


def check(setting: Setting, seed: int) -> None:
    """Raise an error before anything runs if the fleet of a setting cannot be made."""
    try:
        make_fleet_agent(setting.planner, None, seed, setting.layout, 1)
        orders = draw_orders(setting, seed)
        for name in WORLDS:
            make_env(setting, make_world(name, setting, orders[-1].released, seed), orders).close()
    except WarehouseError:
        raise
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def table_of(scores: SeedScores, title: str) -> TextTable:
    """Return a table of the measures with a row for each world."""
    few = len(scores[PLAN]) < MIN_VALUES
    caption = f"Intervals need at least {MIN_VALUES} episodes." if few else ""
    rows = [
        (world, *(cell_of(runs, scores[PLAN], value) for value in MEASURES.values()))
        for world, runs in scores.items()
    ]
    return TextTable(("world", *MEASURES), rows, title, caption)


def cell_of(runs: Sequence[Score], plans: Sequence[Score], value: Value) -> str:
    """Format the mean of a value over the seeds, with its interval unless its width is 0."""
    values = np.array([value(score, plan) for score, plan in zip(runs, plans, strict=True)])
    mean = mean_interval(values[~np.isnan(values)]) or Interval(math.nan)
    if math.isnan(mean.estimate):  # a share of nothing
        return "none"
    if mean.estimate.is_integer() and (mean.low == mean.high or not mean.is_known):
        return f"{mean.estimate:,.0f}"
    return above_interval(mean)


def losses(scores: SeedScores, orders: int) -> list[str]:
    """Return a warning for each world with undelivered orders, lost robots or missing plans.

    Args:
        scores: measures of all runs.
        orders: number of orders in each run.
    """
    found = []
    for world, runs in scores.items():
        counts = {
            "order": ("not delivered", sum(orders - run.delivered for run in runs)),
            "robot": ("lost", sum(run.lost for run in runs)),
            "step": ("without a plan", sum(run.late_plans for run in runs)),
        }
        words = [
            f"{counted(number, noun)} {fate}" for noun, (fate, number) in counts.items() if number
        ]
        if words:
            found.append(f"{world}, in {counted(len(runs), 'episode')}: {listed(words)}")
    return found


def write_values(path: Path, scores: SeedScores, seeds: Sequence[int]) -> None:
    """Write a CSV file with a line for each run."""
    lines = (
        [world, seed, *run]
        for world, runs in scores.items()
        for seed, run in zip(seeds, runs, strict=True)
    )
    write_table(path, ["world", "seed", *Score._fields], lines)


def write_page(path: Path, table: TextTable, records: Mapping[str, FleetEpisode]) -> None:
    """Write a page with the table and a replay of the records of all worlds on one clock."""
    from markupsafe import Markup

    from agents.lab.reports.page import Page, Section, write_page  # imports matplotlib
    from warehouse_core.viz.player import player_frame
    from warehouse_core.viz.tracks import track_of_record

    tracks = []
    for world, record in records.items():
        track = track_of_record(record, FRAME_SECONDS)
        track.title, track.lateness = world, ()  # it is in steps, whose length differs by world
        for frame in track.frames:
            frame.energy = 0.0  # the chart of all worlds shows the energy
        tracks.append(track)
    title = "A fleet on the grid and on rigid bodies"
    rows = [tuple(cell.replace("\n", " ") for cell in row) for row in table.rows]
    replay = player_frame(tracks, title=title, speed=SPEED, height=HEIGHT)
    sections = [
        Section("Measures of all worlds", [table._replace(rows=rows, title="")]),
        Section("All worlds on one clock", [Markup(replay)]),
    ]
    write_page(path, Page(title, [f"{table.title}."], sections))
