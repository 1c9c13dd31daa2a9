"""Plans for robots that drive through, and how they are executed."""

import math
import random
from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st

from helpers.driving_validator import motion_fault, too_near
from warehouse_core import Cell, Layout
from warehouse_core.motion.traffic import find_stops
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.tiles import moved
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec

MAX_SECONDS, MAX_REST_SECONDS = 100, 1000
RESTS = 1e-5
"""Metres by which a robot that is at rest may move in a substep."""


def resolved(
    layout: Layout, cells: list[Cell], actions: Sequence[Sequence[int]]
) -> list[list[Cell]]:
    """Return the joint plan of actions; robots that walls or other robots would stop stay."""
    plan = [cells]
    for row in actions:
        targets = [
            moved(cell, DISPLACEMENTS[action]) for cell, action in zip(plan[-1], row, strict=True)
        ]
        stops = find_stops(layout, plan[-1], targets)
        ends = zip(plan[-1], targets, stops, strict=True)
        plan.append([target if stop is None else cell for cell, target, stop in ends])
    return plan


@st.composite
def crowds(
    draw: st.DrawFn, walls: str = "....#"
) -> tuple[Layout, list[list[Cell]], list[bool], random.Random]:
    """Generate a small layout, a plan for robots in it, their loads, and random numbers."""
    height, width = draw(st.integers(1, 4)), draw(st.integers(2, 5))
    stream = random.Random(draw(st.integers(0, 10**6)))
    rows = ["".join(stream.choice(walls) for _ in range(width)) for _ in range(height)]
    layout = Layout([*rows, "." * width])
    cells = [divmod(int(cell), width) for cell in layout.open_cells]
    starts = stream.sample(cells, draw(st.integers(1, min(len(cells), 8))))
    action = st.sampled_from([0, 1, 2, 3, 0, 1, 2, 3, 4])
    actions = draw(st.lists(st.tuples(*[action] * len(starts)), max_size=12))
    loaded = [stream.random() < 0.5 for _ in starts]
    return layout, resolved(layout, starts, actions), loaded, stream


class Drive:
    """Robots that have driven through a plan, with a pause between its joint steps.

    Attributes:
        positions: ``[N, R, 2]`` metres at each substep, until all are at rest.
        seconds: ``N - 1`` substeps.
        joules: ``[R]``, cost until then.
        hits: number of contacts.
    """

    def __init__(
        self,
        layout: Layout,
        plan: Sequence[Sequence[Cell]],
        spec: RobotSpec | None = None,
        loaded: Sequence[bool] = (),
        pause: float = 0.0,
    ) -> None:
        motion = DrivingMotion(spec, path_every=1)
        motion.reset(layout, plan[0], 0)
        robots, self.hits = len(plan[0]), 0
        self.joules, self._paths = np.zeros(robots), []
        self._drive = motion.drive
        if any(loaded):
            motion.advance([(0, 0)] * robots, loaded)
        for cells in plan[1:]:
            motion.extend(cells)
            if pause:
                self._go(pause)
        while not all(motion.routes().at_rest) or not self._paths:
            self._go(1.0)
            assert len(self._paths) < MAX_SECONDS, "robots do not arrive"
        rows = np.concatenate([self._paths[0][:1], *(each[1:] for each in self._paths)])
        moves = np.flatnonzero(np.abs(np.diff(rows, axis=0)).max(axis=(1, 2)) > RESTS)
        last = moves[-1] + 1 if len(moves) else 0
        self.positions, self.seconds = rows[: last + 1], last * motion.spec.time_step
        self.joules -= motion.spec.idle_power * ((len(rows) - 1 - last) * motion.spec.time_step)

    def _go(self, seconds: float) -> None:
        outcomes = self._drive(seconds)
        self.joules += [outcome.joules for outcome in outcomes]
        self.hits += sum(len(outcome.contacts) for outcome in outcomes)
        self._paths.append(np.stack([outcome.path[:, 1:3] for outcome in outcomes], axis=1))


class Failures:
    """Robots that execute a plan while some of them fail, perhaps with disturbances."""

    def __init__(
        self,
        layout: Layout,
        plan: list[list[Cell]],
        spec: RobotSpec,
        loaded: list[bool],
        disturbances: Disturbances | None = None,
    ) -> None:
        self.motion = DrivingMotion(spec, disturbances, path_every=1)
        self._layout, self._loaded = layout, loaded
        self.motion.reset(layout, plan[0], 0)
        self._paths: list[np.ndarray] = []
        self.hits = 0
        self.move([(0, 0)] * len(loaded))
        for cells in plan[1:]:
            self.motion.extend(cells)

    def drive(self, seconds: float) -> None:
        self._add(self.motion.drive(seconds))

    def move(self, displacements: list[Cell]) -> None:
        self._add(self.motion.advance(displacements, self._loaded))

    def _add(self, outcomes: list) -> None:
        self._paths.append(np.stack([outcome.path[:, 1:3] for outcome in outcomes], axis=1))
        self.hits += sum(len(outcome.contacts) for outcome in outcomes)

    def come_to_rest(self) -> None:
        """Drive until all robots that have not failed are at rest in different open cells."""
        for _ in range(MAX_REST_SECONDS):
            routes = self.motion.routes()
            if all(
                rests or fails for rests, fails in zip(routes.at_rest, routes.failed, strict=True)
            ):
                break
            self.drive(1.0)
        else:
            raise AssertionError(f"robots do not arrive: {routes}")
        self.drive(2.0)
        live = [end for end, fails in zip(routes.ends, routes.failed, strict=True) if not fails]
        assert len({*live, *routes.closed}) == len(live) + len(routes.closed)
        for robot, (row, col) in enumerate(routes.ends):
            assert self._layout.is_open((row, col))
            assert not routes.failed[robot] or (row, col) in routes.closed
            if not routes.failed[robot]:
                x, y = self._paths[-1][-1, robot]
                assert math.dist((x, y), (col + 0.5, row + 0.5)) < 2e-3

    def check(self) -> None:
        """Check all motion so far."""
        rows = [self._paths[0][:1], *(path[1:] for path in self._paths)]
        assert self.hits == 0
        fault_of = too_near if self.motion.disturbances.any else motion_fault
        assert fault_of(np.concatenate(rows), self.motion.spec) is None
