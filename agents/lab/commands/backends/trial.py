"""A run of a fleet in one of four worlds, and its measures in seconds.

The worlds are the plan on the grid, bodies that stop in every cell, bodies that drive through, and
these with disturbances. Orders arrive and are due at the same seconds in all of them.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from agents.errors import EpisodeError
from agents.fleet.planned import PlannedFleet, wants_dispatch
from agents.lab.console.watch import slow_steps_reported
from agents.lab.runs.run import run
from agents.registry import make_fleet_agent
from warehouse_core import Cell, FleetEnv, FleetEpisode, Layout, LayoutError, Order, Outcome
from warehouse_core.batch.tally import SECONDS_PER_HOUR
from warehouse_core.fleet import Battery
from warehouse_core.motion.backends import load_backend
from warehouse_core.motion.base import Motion
from warehouse_core.motion.grid import NOMINAL_SECONDS

PLAN, STOPPING, DRIVING, DISTURBED = WORLDS = (
    "grid plan",
    "stopping",
    "driving through",
    "disturbed",
)

STEPS_OF_A_CELL = 4
"""Steps in which a robot that drives through crosses a cell. With one, paths would grow no faster
than they are driven, so that corners would be known too late, and robots that have come to rest
would wait for the next step."""

BATTERY, DUE = Battery(30_000, "joules"), (100, 300)
"""Battery of the robots, and fewest and most seconds from the release of an order to its due time.
A charger supplies as much in a second in all worlds."""

MAX_SECONDS = 600.0
"""Time allowed for each order of a robot beyond the last due time; a longer run is ended."""


@dataclass(frozen=True)
class Setting:
    """The fleet, floor and orders that the worlds have in common.

    Attributes:
        rate: orders that are released in a second on average.
        count: orders of an episode.
        noise: standard deviation of disturbed speeds as a share of the commanded ones.
        stop: seconds that one disturbed robot stands still; with 0 none does, with inf it dies.
    """

    layout: Layout
    robots: int
    planner: str
    rate: float
    count: int
    noise: float
    stop: float


class TimedOrder(NamedTuple):
    """An item to be brought from a pickup to a dropoff; times are seconds from the reset."""

    released: float
    due: float
    pickup: Cell
    dropoff: Cell


class World(NamedTuple):
    """A factory of the motion of a fleet, and the nominal seconds of a step."""

    motion: Callable[[], Motion]
    step_seconds: float


class Score(NamedTuple):
    """The measures of a run; times are by the clock of its world.

    Attributes:
        per_hour: deliveries in an hour, until the last one.
        on_time: share of all orders that were delivered by their due times.
        joules: energy of all robots for a delivery.
        hits: contacts, of which two robots that touch have one.
        makespan: seconds until the last delivery.
        delivered: number of delivered orders.
        lost: robots whose battery is empty, or that have died.
        late_plans: steps in which all robots waited for a plan.
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

    Stations are drawn equally often, and so are times from release to due time.
    """
    layout, count, stream = setting.layout, setting.count, np.random.default_rng(seed)
    for kind, places in (("pickup", layout.pickups), ("dropoff", layout.dropoffs)):
        if not places:
            raise LayoutError(f"the layout has no {kind}; orders are drawn from its stations")
    released = stream.exponential(1 / setting.rate, count).cumsum()
    dues = released + stream.uniform(*DUE, count)
    pickups, dropoffs = (
        [places[number] for number in stream.integers(len(places), size=count)]
        for places in (layout.pickups, layout.dropoffs)
    )
    return list(map(TimedOrder, released.tolist(), dues.tolist(), pickups, dropoffs))


def in_steps(orders: Sequence[TimedOrder], seconds: float) -> list[Order]:
    """Return orders for a fleet whose steps last so many seconds.

    None is released too early, and none is due too late, unless it is due before it is released.
    """
    releases = [math.ceil(order.released / seconds) for order in orders]
    return [
        Order(released, max(math.floor(order.due / seconds), released), *order[2:])
        for released, order in zip(releases, orders, strict=True)
    ]


def make_world(name: str, setting: Setting, busy_seconds: float, seed: int) -> World:
    """Return a world by name.

    A step of the grid lasts for the time of a cell at top speed, and has ``STEPS_OF_A_CELL`` steps
    of robots that drive through. Where all robots stop in each cell, a step lasts until a loaded
    robot is at rest. A disturbed robot stops in the first half of the time in which orders come.
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
    from warehouse_physics import Disturbances, Stop  # loading pymunk takes long

    stream = np.random.default_rng(seed)
    robot, at = int(stream.integers(setting.robots)), float(stream.uniform(0, busy_seconds / 2))
    stops = (Stop(robot, at, setting.stop),) if setting.stop else ()
    shocks = Disturbances(actuation_noise=setting.noise, stops=stops)
    return World(partial(driving, disturbances=shocks, period=period), period)


def make_env(
    setting: Setting, world: World, orders: Sequence[TimedOrder], dispatch: bool = True
) -> FleetEnv:
    """Return the fleet of a setting in a world; a ``ValueError`` says why it cannot be made."""
    motion = world.motion()
    charge = BATTERY.step_charge(motion.cell_size) * world.step_seconds
    seconds = max(order.due for order in orders)
    seconds += MAX_SECONDS * math.ceil(len(orders) / setting.robots)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that batteries would not last for so long
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
    """Run a fleet until all orders are delivered; return the record only for the seed ``kept``."""
    orders = draw_orders(setting, seed)
    made = make_world(world, setting, orders[-1].released, seed)
    agent = make_fleet_agent(setting.planner, None, seed, setting.layout, setting.robots)
    told = slow_steps_reported(agent, setting.planner)
    with closing(make_env(setting, made, orders, wants_dispatch(agent))) as env:
        try:
            record = run(env, agent, seed, told, name=setting.planner)
        except EpisodeError as error:
            # Without its record, which would go from process to process.
            raise EpisodeError(f"world {world}, {error}") from None
    late_plans = len(agent.lost) if isinstance(agent, PlannedFleet) else 0
    return score_of(record, orders, late_plans), record if seed == kept else None


def score_of(record: FleetEpisode, orders: Sequence[TimedOrder], late_plans: int) -> Score:
    """Return the measures of a record, whose orders were made of ``orders``, one by one."""
    steps = record.seconds.max(axis=1)
    # A drop that takes longer than the step in which it begins has not ended with it.
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
    """Return the number of contacts, each of which is in the outcomes of both robots that touch."""
    found = {
        (step, contact.seconds, frozenset((f"robot {robot}", contact.counterpart)))
        for step, outcomes in enumerate(steps)
        for robot, outcome in enumerate(outcomes)
        for contact in outcome.contacts
    }
    return len(found)
