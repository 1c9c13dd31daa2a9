"""Execution of a joint plan by physical bodies: driven through, or one joint step after another.

A plan says in which step each robot is in which cell, but bodies need different times for their
moves. When bodies drive through, they pass each cell in the order of the plan and wait for nothing
else. In joint steps, all bodies wait after each step until the last one has come to rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agents.errors import PlanError
from warehouse_core import Cell, Layout, Outcome
from warehouse_core.motion.base import Routes
from warehouse_core.wording import listed
from warehouse_core.world.tables import Integers
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec
from warehouse_physics.profile import Floats
from warehouse_physics.spec import ARRIVED

PATIENCE = 10.0
"""Seconds without any movement after which the robots count as deadlocked, apart from stops."""

MAX_SLOWNESS = 10
"""Limit on the time, as a multiple of the time of robots that drive one after another."""

MAX_TRIES = 10
"""Attempts at a joint step that disturbances make fail."""

RESTS = 1e-5
"""Metres between two rows of its path up to which a robot counts as being at rest."""


class Execution(NamedTuple):
    """Time, energy and hits of a plan that ``R`` bodies have carried out.

    Attributes:
        seconds: time until all bodies are at rest in their last cells.
        joules: energy of all bodies until then.
        hits: number of hits. A hit between two robots counts for both.
        arrivals: ``[R]``, seconds until each body is at rest in its last cell for good.
    """

    seconds: float
    joules: float
    hits: int
    arrivals: Floats


def drive_through(
    layout: Layout,
    plan: Integers,
    spec: RobotSpec | None = None,
    disturbances: Disturbances | None = None,
) -> Execution:
    """Let bodies drive through the cells of a joint plan, ``[T + 1, R]``; return the execution.

    Raises:
        PlanError: all robots have stopped before all have arrived. The message names robots.
        LayoutError: a robot starts in a wall or in the cell of another robot.
        ValueError: a joint step has a conflict, or the robots are too wide to follow each other.
    """
    motion = DrivingMotion(spec, disturbances, path_every=1)
    cells = [*map(layout.cells, plan)]
    motion.reset(layout, cells[0], seed=0)
    for targets in cells[1:]:
        motion.extend(targets)
    stops = [stop.seconds for stop in motion.disturbances.stops if stop.seconds < math.inf]
    patience = PATIENCE + sum(stops)
    alone = np.count_nonzero(np.diff(plan, axis=0)) * motion.spec.move_seconds(loaded=False)
    record, moved_at = _Record(motion.spec, len(cells[0])), 0.0
    while late := _late(motion.routes(), cells[-1]):
        if record.add(motion.drive(motion.period)):
            moved_at = record.now
        if record.now > min(moved_at + patience, patience + MAX_SLOWNESS * alone):
            raise PlanError(f"after {record.now:.0f} s {_named(late)} not arrived")
    return record.execution()


def drive_steps(
    layout: Layout,
    plan: Integers,
    spec: RobotSpec | None = None,
    disturbances: Disturbances | None = None,
) -> Execution:
    """Let bodies carry out a joint plan, ``[T + 1, R]`` cells, step by step.

    If disturbances keep robots from their cells, these robots try again while the others wait.

    Raises:
        PlanError: robots cannot carry out a step. The message names them.
        LayoutError: as for ``drive_through``.
        ValueError: a robot is to move by more than a cell.
    """
    motion, cells = RigidBodyMotion(spec, disturbances), [*map(layout.cells, plan)]
    motion.reset(layout, cells[0], seed=0)
    record, here = _Record(motion.spec, len(cells[0])), cells[0]
    for step, targets in enumerate(cells[1:]):
        for _ in range(MAX_TRIES):
            moves = [(to[0] - at[0], to[1] - at[1]) for at, to in zip(here, targets, strict=True)]
            outcomes = motion.advance(moves, [False] * len(moves))
            record.add(outcomes)
            here = [outcome.cell for outcome in outcomes]
            if here == targets:
                break
        else:
            late = [robot for robot, cell in enumerate(here) if cell != targets[robot]]
            raise PlanError(f"in joint step {step} {_named(late)} not arrived")
    return record.execution()


EXECUTIONS = {"joint steps": drive_steps, "driven through": drive_through}
"""Functions that execute a plan, by name."""


class _Record:
    """Accumulated results of an execution, outcome by outcome."""

    def __init__(self, spec: RobotSpec, robots: int) -> None:
        self._spec, self._arrivals = spec, np.zeros(robots)
        self.now, self._work, self._hits = 0.0, 0.0, 0

    def add(self, outcomes: Sequence[Outcome]) -> bool:
        """Add the next outcome of each robot, and return whether any robot has made progress."""
        has_moved = False
        for robot, outcome in enumerate(outcomes):
            path = outcome.path
            moves = np.flatnonzero(np.abs(np.diff(path[:, 1:3], axis=0)).max(axis=1) > RESTS)
            if len(moves):
                self._arrivals[robot] = self.now + path[moves[-1] + 1, 0]
            distance = np.abs(path[-1, 1:3] - path[0, 1:3]).max()
            has_moved |= bool(distance > ARRIVED * self._spec.cell_size)
            self._work += outcome.joules - self._spec.idle_power * outcome.seconds
            self._hits += len(outcome.contacts)
        self.now += max(outcome.seconds for outcome in outcomes)
        return has_moved

    def execution(self) -> Execution:
        """Return the whole execution. All robots draw idle power until the last one has arrived."""
        seconds = float(self._arrivals.max())
        idle = self._spec.idle_power * seconds * len(self._arrivals)
        return Execution(seconds, self._work + idle, self._hits, self._arrivals)


def _late(routes: Routes, goals: Sequence[Cell]) -> list[int]:
    """Return the robots that are not at rest in their last cells, as routes may be cut short."""
    each = enumerate(zip(routes.ends, routes.at_rest, goals, strict=True))
    return [robot for robot, (end, rests, goal) in each if not rests or end != goal]


def _named(robots: Sequence[int]) -> str:
    return f"robot{'s' if robots[1:] else ''} {listed(robots)} {'have' if robots[1:] else 'has'}"
