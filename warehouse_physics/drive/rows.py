"""The warehouse under continuous control: ``B`` rows with a robot, a task and an episode each.

``DriveEnv`` is one row and ``DriveVectorEnv`` many. A row has the task, the rewards and the random
stations of ``WarehouseEnv``; see ``task/rules.py`` and ``reset(randomize=True)``. The differences:

===============  ==================================================================================
Picking          happens after the robot has stood in the cell of a pickup for ``spec.dwell``
and dropping     seconds, slower than ``STANDING`` times its top speed. Dropping is alike.
Rewards          The penalty of a step is spread over the time of a free move over one cell. A hit
                 costs ``BLOCKED_REWARD`` times its impulse, as a share of the impulse of the empty
                 robot at top speed.
Battery          is in joules. On a charger a standing robot gains what a step on it would give.
Ends             Terminated when the item is delivered. Truncated when the time is up or the battery
                 is empty.
===============  ==================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core import Cell, Layout, LayoutError, WarehouseEnv
from warehouse_core.motion.base import SCAN_RANGE, centre_of
from warehouse_core.task.rules import (
    BLOCKED_REWARD,
    CHARGE,
    DROP_REWARD,
    PICK_REWARD,
    STEP_REWARD,
)
from warehouse_core.world.layout import check_open
from warehouse_core.world.rays import WallRays
from warehouse_core.world.tables import Flags
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP
from warehouse_physics.disturbances import Disturbances, FloorConditions
from warehouse_physics.drive.bodies import Bump, DriveBodies
from warehouse_physics.drive.drives import BodyState, Loads, drive_of
from warehouse_physics.energy import joules_of, move_joules
from warehouse_physics.odometry import Odometry
from warehouse_physics.profile import Floats, lengths_of
from warehouse_physics.spec import RobotSpec

STANDING = 0.1
"""Speed below which a robot stands, as a share of its top speed. A robot that brakes for a station
at 10 commands a second comes below it in one or two of them."""

BUDGET = 200
"""Default limits of an episode, as the number of moves over one cell: the chapter's 200 steps and
200 units of the battery."""

TASKS = {PICKUP: 1, DROPOFF: 2, CHARGER: 3}
"""Codes of the tiles on which standing has an effect."""


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """What all rows have in common; see the arguments of ``DriveEnv``."""

    layout: Layout
    control: str
    spec: RobotSpec
    disturbances: Disturbances
    rate: float
    rays: int
    randomize: bool | str
    start_pos: Cell | None
    max_seconds: float
    battery: float
    substeps: int


@dataclass(slots=True)
class DriveStep:
    """What happened in a step, as arrays ``[B]``.

    Attributes:
        rewards: float64.
        terminated: bool.
        truncated: bool.
        joules: float64, energy that the batteries lost.
        impulses: float64, sum of the impulses of the hits in N·s.
        bumps: the hits, with the seconds since the start of the step.
        trace: state and motor forces after each substep, if it is to be recorded.
    """

    rewards: Floats
    terminated: Flags
    truncated: Flags
    joules: Floats
    impulses: Floats
    bumps: list[tuple[float, Bump]] = field(default_factory=list)
    trace: list[tuple[BodyState, Floats, Floats]] = field(default_factory=list)


class DriveRows:
    """``B`` robots in warehouses of their own; see the top of this file.

    Attributes:
        settings: settings of all rows.
        bodies: bodies of the robots.
        state: positions and velocities of the robots.
        layouts: layout of each row, with its stations.
        starts: cell in which each row began.
        has_item: ``[B]`` bool.
        batteries: ``[B]`` joules left.
        seconds: ``[B]`` seconds since the start of the episode.
        stood: ``[B]`` seconds for which the robot has stood where it can pick or drop.
    """

    def __init__(self, settings: DriveSettings, rows: int) -> None:
        self.settings, self._spec = settings, settings.spec
        self.bodies = DriveBodies(settings.spec, settings.layout, rows)
        self._drive = drive_of(settings.spec, settings.control, rows)
        self._rays = WallRays(settings.layout)
        self._angles = np.arange(settings.rays) * (math.tau / max(settings.rays, 1))
        self._task = WarehouseEnv(settings.layout, settings.start_pos)
        self.layouts, self.starts = [settings.layout] * rows, [self._task.start_pos] * rows
        self.has_item = np.zeros(rows, np.bool_)
        self.batteries, self.seconds, self.stood = np.zeros((3, rows))
        self._tiles = np.zeros((rows, settings.layout.height * settings.layout.width), np.int8)
        self._goals = np.zeros((2, rows, 2))
        self._floors: list[FloorConditions] = [FloorConditions(Disturbances(), 0)] * rows
        self._odometers: dict[int, Odometry] = {}
        self._loads = Loads(rows)
        self._is_felt = settings.disturbances.is_felt
        self._cells = np.full((rows, 2), -1)
        self.scanner: Callable[[int], Floats] | None = None
        self._scans: Floats | None = None
        self.state = self.bodies.read()

    def begin(
        self,
        rows: Sequence[int],
        seeds: Sequence[int],
        layout: Layout | None = None,
        start: Cell | None = None,
    ) -> None:
        """Start episodes in some rows, which draw the same stations as ``WarehouseEnv.reset``.

        A layout with the same walls, and a start, replace the random ones.

        Raises:
            LayoutError: the walls differ, or the start is not open.
        """
        for row, seed in zip(rows, seeds, strict=True):
            self._begin(row, seed, *self._drawn(seed, layout, start))
        where = list(rows)
        self.has_item[where], self.stood[where], self.seconds[where] = False, 0.0, 0.0
        self.batteries[where] = self.settings.battery
        self._cells[where] = -1
        self.state, self._scans = self.bodies.read(), None
        self._feel(np.array(where))

    def _drawn(self, seed: int, layout: Layout | None, start: Cell | None) -> tuple[Layout, Cell]:
        task = self._task
        task.reset(randomize=self.settings.randomize, seed=seed)
        if layout is None:
            layout = task.layout
        elif not np.array_equal(layout.open_cells, self.settings.layout.open_cells):
            raise LayoutError(
                "the layout of an episode must have the same walls as its environment"
            )
        start = task.state.robot_pos if start is None else start
        check_open(layout, start, "start_pos")
        return layout, start

    def _begin(self, row: int, seed: int, layout: Layout, start: Cell) -> None:
        size, spec = self._spec.cell_size, self._spec
        self.layouts[row], self.starts[row] = layout, start
        self.bodies.place(row, centre_of(start, size), spec.mass)
        self._tiles[row] = 0
        for stations, tile in (
            (layout.pickups, PICKUP), (layout.dropoffs, DROPOFF), (layout.chargers, CHARGER),
        ):  # fmt: skip
            self._tiles[row, [layout.number(cell) for cell in stations]] = TASKS[tile]
        for kind, cells in enumerate((layout.pickups, layout.dropoffs)):
            self._goals[kind, row] = centre_of((cells or (start,))[0], size)
        disturbances = self.settings.disturbances
        self._floors[row] = FloorConditions(disturbances, seed)
        if disturbances.odometry:
            self._odometers[row] = Odometry([centre_of(start, size)], disturbances.odometry, seed)

    def step(self, actions: Floats, *, is_traced: bool = False) -> DriveStep:
        """Carry out actions ``[B, 2]`` from -1 to 1 for one period of the controller."""
        settings, drive, bodies = self.settings, self._drive, self.bodies
        commands = drive.command(actions)
        if settings.disturbances.actuation_noise:
            factors = np.array([floor.speed_factor() for floor in self._floors])
            commands = commands * factors
        rows, dt = len(actions), self._spec.time_step
        step = DriveStep(*np.zeros((1, rows)), *np.zeros((2, rows), np.bool_), *np.zeros((2, rows)))
        start, work = self.state, np.zeros(rows)
        speeds = drive.speeds(start)
        for substep in range(1, settings.substeps + 1):
            push = drive.push(self.state, speeds, commands, self._loads)
            for bump in bodies.step(push):
                if bump.impulse > 0:  # not if they slide along each other or already separate
                    step.impulses[bump.row] += bump.impulse
                    step.bumps.append((substep * dt, bump))
            self.state, before = bodies.read(), speeds
            speeds = drive.speeds(self.state)
            work += drive.work(push, before, speeds)
            if is_traced:
                joules = joules_of(self._spec, work, substep * dt)
                step.trace.append((self.state, push.motors.T, joules))
            if self._is_felt:
                self._feel()
        step.joules += joules_of(self._spec, work, settings.substeps * dt)
        self._scans = None
        self._measure(start)
        self._judge(step, settings.substeps * dt)
        return step

    def cells(self) -> NDArray[np.intp]:
        """Return the row and column of each robot, ``[B, 2]``."""
        places = self.state.positions[:, ::-1] / self._spec.cell_size
        return np.floor(places).astype(np.intp)

    def poses(self) -> Floats:
        """Return the poses ``[B, 3]`` that the robots believe they have: x, y and heading."""
        poses = np.column_stack([self.state.positions, self.state.angles])
        for row, odometer in self._odometers.items():
            poses[row] = odometer.poses[0]
        return poses

    def goals(self) -> Floats:
        """Return where the robots have to go next, ``[B, 2]`` metres.

        This is the pickup, and with an item the dropoff. Without such a station it is the start.
        """
        goals: Floats = np.where(self.has_item[:, None], self._goals[1], self._goals[0])
        return goals

    def scans(self) -> Floats:
        """Return the distances in metres that the rays of each robot measure, ``[B, K]``.

        Ray 0 is straight ahead. A lone warehouse with other things has a ``scanner`` for them.
        """
        if self._scans is None:
            size = self._spec.cell_size
            reach, places = SCAN_RANGE / size, self.state.positions / size
            self._scans = (
                self._rays.distances(places, self._ray_angles(), reach) * size
                if self.scanner is None
                else self.scanner(self.settings.rays)[None]
            )
        return self._scans

    def ray_ends(self) -> Floats:
        """Return the places in metres at which the rays of each robot end, ``[B, K, 2]``."""
        angles = self._ray_angles()
        ways = self.scans()[..., None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        ends: Floats = self.state.positions[:, None] + ways
        return ends

    def _ray_angles(self) -> Floats:
        angles: Floats = self.state.angles[:, None] + self._angles
        return angles

    def _feel(self, rows: Any = None) -> None:
        """Update the loads of robots that have entered another cell, or of given rows."""
        cells = self.cells()
        if rows is None:
            rows = np.flatnonzero((cells != self._cells).any(axis=1))
        spec, loads = self._spec, self._loads
        self._cells[rows] = cells[rows]
        if not self._is_felt:
            loaded = self.has_item[rows]
            loads.masses[rows] = np.where(loaded, spec.total_mass(True), spec.total_mass(False))
            loads.drags[rows] = np.where(loaded, spec.drag_force(True), spec.drag_force(False))
            loads.motors[rows], loads.grips[rows] = spec.motor_force, math.inf
            loads.settle()
            return
        for row in rows.tolist():
            floor, loaded = self._floors[row], bool(self.has_item[row])
            row_col = int(cells[row, 0]), int(cells[row, 1])
            mass = spec.total_mass(loaded)
            loads.masses[row] = mass
            loads.drags[row] = spec.drag_force(loaded) * floor.drag_factor(row_col)
            loads.motors[row] = floor.force_limit(row_col, spec.motor_force, mass)
            loads.grips[row] = floor.grip_force(row_col, mass)
        loads.settle()

    def _measure(self, start: BodyState) -> None:
        """Let odometers measure the motion of a step that began with ``start``."""
        for row, odometer in self._odometers.items():
            ends = [[0.0, *each.positions[row], each.angles[row]] for each in (start, self.state)]
            odometer.measure([np.array(ends)])

    def _judge(self, step: DriveStep, period: float) -> None:
        """Let robots pick, drop and charge, and set the rewards and the ends of episodes."""
        spec, settings, cells = self._spec, self.settings, self.cells()
        numbers = cells[:, 0] * settings.layout.width + cells[:, 1]
        tiles = self._tiles[np.arange(len(numbers)), numbers]
        stands = lengths_of(self.state.velocities) < STANDING * spec.top_speed
        stands &= np.abs(self.state.turn_rates) * spec.radius < STANDING * spec.top_speed
        wanted = np.where(self.has_item, TASKS[DROPOFF], TASKS[PICKUP])
        self.stood = np.where(stands & (tiles == wanted), self.stood + period, 0.0)
        is_done = self.stood >= spec.dwell - period / 2
        drops, picks = is_done & self.has_item, is_done & ~self.has_item
        self.seconds += period
        self.batteries -= step.joules
        charges = np.flatnonzero(stands & (tiles == TASKS[CHARGER]))
        if charges.size:
            charge = CHARGE * move_joules(spec, loaded=True) * period / spec.move_seconds(False)
            gained = self.batteries[charges] + charge
            self.batteries[charges] = np.minimum(gained, settings.battery)
        step.rewards += STEP_REWARD * period / spec.move_seconds(False)
        step.rewards += BLOCKED_REWARD * step.impulses / (spec.mass * spec.top_speed)
        step.rewards += PICK_REWARD * picks + DROP_REWARD * drops
        if is_done.any():
            self._load(np.flatnonzero(is_done))
        step.terminated = drops
        step.truncated = (self.seconds >= settings.max_seconds - period / 2) | (self.batteries <= 0)

    def _load(self, rows: NDArray[np.intp]) -> None:
        """Let robots that have picked or dropped change their mass."""
        self.has_item[rows] = ~self.has_item[rows]
        self.stood[rows] = 0.0
        for row in rows.tolist():
            self.bodies.load(row, self._spec.total_mass(bool(self.has_item[row])))
        self._feel(rows)


def settings_of(
    layout: Layout,
    control: str,
    spec: RobotSpec,
    disturbances: Disturbances,
    rate: float,
    **others: Any,
) -> DriveSettings:
    """Return settings whose robot has substeps that divide the period of the controller.

    The substeps are also so short that a robot at its top speed does not sink deep into walls.
    """
    fastest = disturbances.highest_speed(spec.top_speed) or spec.top_speed
    spec = spec.refined(fastest)
    substeps = math.ceil(1 / rate / spec.time_step - 1e-9)
    spec = replace(spec, time_step=1 / rate / substeps)
    seconds, battery = others.pop("max_seconds"), others.pop("battery")
    return DriveSettings(
        layout, control, spec, disturbances, rate, substeps=substeps,
        max_seconds=BUDGET * spec.move_seconds(loaded=False) if seconds is None else seconds,
        battery=BUDGET * move_joules(spec, loaded=True) if battery is None else battery,
        **others,
    )  # fmt: skip
