"""A run of a fleet in one of the worlds, and its measures in seconds."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from agents.errors import EpisodeError
from agents.fleet.planned import DEFAULT_ASSIGNMENT, PlannedFleet, wants_dispatch
from agents.lab.commands.gap.alone import AloneFleet
from agents.lab.commands.gap.orders import TimedOrder, draw_orders, in_steps
from agents.lab.commands.gap.spent_time import time_spent
from agents.lab.commands.gap.worlds import ALONE, Shocks, World, make_world
from agents.lab.console.watch import slow_steps_told
from agents.lab.runs.run import run
from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, FleetEpisode, Layout, Outcome
from warehouse_core.batch.fleet_settings import JOULES
from warehouse_core.batch.tally import SECONDS_PER_HOUR
from warehouse_core.fleet import Battery
from warehouse_core.motion.grid import NOMINAL_SECONDS
from warehouse_core.records import FleetAgent

TOP_SPEED = 1.0
"""Nominal top speed of the robots of all worlds in m/s."""

MAX_SECONDS = 600.0
"""Time allowed for each order of a robot beyond the last due time; a longer run is ended."""


@dataclass(frozen=True)
class Setting:
    """The fleet, floor and orders that the worlds have in common.

    Of the ``count`` orders ``rate`` are released in a second on average; each is due after the
    fewest to the most seconds of ``due``. Shocks happen in the disturbed world only.
    """

    layout: Layout
    robots: int
    planner: str
    assignment: str | None
    plan_seconds: float
    battery: Battery
    rate: float
    count: int
    due: tuple[int, int]
    shocks: Shocks

    def orders(self, seed: int) -> list[TimedOrder]:
        """Return the orders of a seed."""
        return draw_orders(self.layout, self.rate, self.count, self.due, seed)


class Score(NamedTuple):
    """The measures of a run; times are by the clock of its world.

    Attributes:
        per_hour: deliveries in an hour, until the last one.
        on_time: share of all orders that were delivered by their due times.
        joules: a delivery, of all robots.
        hits: contacts, of which two robots that touch have one.
        makespan: seconds until the last delivery.
        delivered: orders.
        lost: robots whose battery is empty, or that have died.
        spent: seconds a delivery that the robots have spent on each of ``KINDS``.
        late_plans: steps in which all robots waited for a plan.
    """

    per_hour: float
    on_time: float
    joules: float
    hits: int
    makespan: float
    delivered: int
    lost: int
    spent: tuple[float, ...]
    late_plans: int


class GapResult(NamedTuple):
    """The measures of a run, and its record if it is kept."""

    score: Score
    record: FleetEpisode | None


def run_trial(world: str, seed: int, *, setting: Setting, kept: int | None = None) -> GapResult:
    """Run a fleet until all orders are delivered; the record of the seed ``kept`` is kept."""
    name, orders = setting.planner, setting.orders(seed)
    motion = make_world(world, setting.shocks, setting.robots, orders[-1].released, seed)
    agent: FleetAgent = AloneFleet(setting.assignment or DEFAULT_ASSIGNMENT)
    if world != ALONE:
        agent = make_fleet_agent(
            name, setting.assignment, seed, setting.layout, setting.robots,
            seconds=setting.plan_seconds,
        )  # fmt: skip
    with closing(make_env(setting, motion, orders, wants_dispatch(agent))) as env:
        try:
            record = run(env, agent, seed, slow_steps_told(agent, name), name=name)
        except EpisodeError as error:
            # Without its record, which would go from process to process.
            raise EpisodeError(f"world {world}, {error}") from None
    late_plans = len(agent.lost) if isinstance(agent, PlannedFleet) else 0
    return GapResult(score_of(record, orders, late_plans), record if seed == kept else None)


def make_env(
    setting: Setting, world: World, orders: list[TimedOrder], dispatch: bool = True
) -> FleetEnv:
    """Return the fleet of a setting in a world; a ``ValueError`` says why it cannot be made."""
    battery, motion = setting.battery, world.motion()
    if battery.unit == JOULES:  # a charger supplies as much in a second in all worlds
        charge = battery.step_charge(motion.cell_size) * world.step_seconds
        battery = replace(battery, charge=max(round(charge), 1))
    last = max(order.due for order in orders)
    seconds = last + MAX_SECONDS * math.ceil(len(orders) / setting.robots)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that batteries would not last for so long
        return FleetEnv(
            setting.layout,
            setting.robots,
            backend=motion,
            orders=in_steps(orders, world.step_seconds),
            max_steps=math.ceil(seconds / world.step_seconds),
            battery=battery,
            dispatch=dispatch,
        )


def score_of(record: FleetEpisode, orders: list[TimedOrder], late_plans: int) -> Score:
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
        spent=tuple((time_spent(record, TOP_SPEED) / each).tolist()),
        late_plans=late_plans,
    )


def count_hits(steps: Iterable[Sequence[Outcome]]) -> int:
    """Return the number of contacts in some steps.

    Each of two robots that touch has the contact in its outcome.
    """
    found = {
        (step, contact.seconds, frozenset((f"robot {robot}", contact.counterpart)))
        for step, outcomes in enumerate(steps)
        for robot, outcome in enumerate(outcomes)
        for contact in outcome.contacts
    }
    return len(found)
