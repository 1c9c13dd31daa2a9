"""The driving backend: robots of a fleet that drive through the cells of their ways."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

import numpy as np

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.arguments import real_number, whole_number
from warehouse_core.motion.base import (
    WALL_CONTACT,
    Conditions,
    Contact,
    Ways,
    check_moves,
    check_starts,
)
from warehouse_core.motion.traffic import check_joint_step, find_stops
from warehouse_core.world.tiles import moved
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.driving.arena import DrivingArena
from warehouse_physics.driving.driver import Driver
from warehouse_physics.driving.leaders import corner_distance
from warehouse_physics.exclusive import exclusive
from warehouse_physics.motion import PATH_EVERY, instance
from warehouse_physics.robot_spec import RobotSpec


class DrivingMotion:
    """Moves ``R`` robots as bodies that drive through the cells of their ways.

    Each robot has a way ahead of it, and a displacement appends a cell to its end, which robots
    enter in the order in which it was appended to their ways; see ``Dependencies``. A robot stops
    where its way turns back or ends, or where it has to wait for another one, and with
    ``turn_seconds`` where its way turns, to turn on the spot. A call lasts ``period`` seconds,
    whatever the robots do; those that drive at its end drive on in the next. ``extend`` and
    ``drive`` do the two parts of it for a plan that is known.

    The ``cell`` of an outcome is the one under the body. ``blocked`` means that a way could not be
    extended, by the table of ``motion/traffic.py`` for the ends of the ways.

    Args:
        spec: of the robots.
        disturbances: how far the physics departs from the nominal.
        period: of a call in seconds; ``None`` is the time for a cell at top speed.
        record_path: record the path of each robot, not only its start and end.
        path_every: substeps between rows of a path, at least 1.

    Raises:
        ValueError: ``period`` is not above 0, or the robots are too wide to follow each other.
        TypeError: ``spec`` is no ``RobotSpec``, or ``disturbances`` no ``Disturbances``.
    """

    is_busy = False

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        period: float | None = None,
        record_path: bool = True,
        path_every: int = PATH_EVERY,
    ) -> None:
        self.spec = instance("spec", spec, RobotSpec)
        self.disturbances = instance("disturbances", disturbances, Disturbances)
        corner_distance(self.spec)
        self.cell_size = self.spec.cell_size
        usual = self.cell_size / self.spec.top_speed
        self._substeps = self._substeps_in("period", usual if period is None else period)
        self.period = self._substeps * self.spec.time_step
        # With less ahead of it, a robot would have to brake before the end of the next call.
        self._room = (self.period + self.spec.top_speed / (2 * self.spec.acceleration)) / usual
        self._path_every = whole_number("path_every", path_every, minimum=1)
        self._record_path = record_path
        self._layout: Layout | None = None
        self._driver: Driver | None = None

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, float]) -> DrivingMotion:
        """Return a motion of nominal robots; see ``RobotSpec.from_numbers``."""
        return cls(RobotSpec.from_numbers(numbers))

    @property
    def conditions(self) -> Conditions:
        """Floor and motors, for records."""
        return self.disturbances.conditions

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Build a new arena with robots at rest; see ``Motion.reset``.

        Raises:
            ValueError: a stop of a robot that does not exist.
        """
        check_starts(layout, cells)
        for stop in self.disturbances.stops:
            if stop.robot >= len(cells):
                raise ValueError(f"{stop}: its robot must be at most {len(cells) - 1}")
        self._layout = layout
        # Without a seed use Python's global random numbers, as the chapter does.
        chance = random.getrandbits(32) if seed is None and self.disturbances.any else seed or 0
        arena = DrivingArena(layout, cells, self.spec)
        self._driver = Driver(arena, self.spec, cells, self.disturbances, chance)

    def ways(self) -> Ways:
        """Return what each robot has ahead of it; see ``DrivesThrough``."""
        driver = self._driven()
        ends = [driver.ways.end(robot) for robot in range(len(driver.work))]
        return Ways(
            ends,
            ((driver.left() <= self._room) & ~driver.stands).tolist(),
            driver.at_rest().tolist(),
            driver.failed.tolist(),
            sorted(driver.closed),
        )

    def fail(self, robot: int) -> None:
        """Let a robot stay where it is for good; see ``DrivesThrough``."""
        self._driven().fail(robot)

    @exclusive
    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Extend the ways by displacements, and drive for a period; see ``Motion.advance``.

        A way that is long enough has no room and is not extended.

        Raises:
            RuntimeError: before ``reset``, or while another call is running.
        """
        driver = self._driven()
        assert self._layout is not None
        check_moves(len(driver.work), displacements, loaded)
        ends, room, _, _, closed = self.ways()
        targets = [
            moved(end, displacement) if has_room else end
            for end, displacement, has_room in zip(ends, displacements, room, strict=True)
        ]
        barred = {
            robot: target
            for robot, (end, target) in enumerate(zip(ends, targets, strict=True))
            if target != end and target in closed
        }
        for robot in barred:
            targets[robot] = ends[robot]
        stops = find_stops(self._layout, ends, targets)
        for robot in barred:
            stops[robot] = WALL_CONTACT
        driver.load(loaded)
        driver.extend(
            [
                target if stop is None else end
                for end, target, stop in zip(ends, targets, stops, strict=True)
            ]
        )
        return [
            outcome._replace(blocked=stop is not None)
            for outcome, stop in zip(self._drive(self._substeps), stops, strict=True)
        ]

    @exclusive
    def extend(self, cells: Sequence[Cell]) -> None:
        """Extend the ways by a joint step of a plan, whether they have room or not.

        Args:
            cells: for each robot its next cell, or the end of its way if it waits.

        Raises:
            ValueError: another number of cells than robots, or robots cannot make this step, as
                ``check_joint_step`` says; nothing has changed.
            RuntimeError: as for ``advance``.
        """
        ends = self.ways().ends
        assert self._layout is not None
        check_joint_step(self._layout, ends, cells)
        self._driven().extend(cells)

    @exclusive
    def drive(self, seconds: float) -> list[Outcome]:
        """Drive for some time, rounded to substeps, and return what each robot did.

        Raises:
            ValueError: ``seconds`` is not above 0.
            RuntimeError: as for ``advance``.
        """
        return self._drive(self._substeps_in("seconds", seconds))

    def close(self) -> None:
        """Release the arena; see ``Motion.close``."""
        self._driver = None

    def _drive(self, substeps: int) -> list[Outcome]:
        driver, dt = self._driven(), self.spec.time_step
        before, paths = driver.work.copy(), [driver.rows(0.0)]
        contacts: list[list[Contact]] = [[] for _ in before]
        for substep in range(1, substeps + 1):
            for hit in driver.step():
                contact = Contact(substep * dt, hit.impulse, hit.point, hit.counterpart)
                contacts[hit.robot].append(contact)
            if substep == substeps or (self._record_path and substep % self._path_every == 0):
                paths.append(driver.rows(substep * dt))
        seconds, rows = substeps * dt, np.stack(paths, axis=1)
        rows.flags.writeable = False
        work = (driver.work - before) / self.spec.drivetrain_efficiency
        joules = (work + self.spec.idle_power * seconds).tolist()
        columns, lines = np.floor(driver.positions / self.cell_size).astype(int).T.tolist()
        return [
            Outcome((row, col), False, seconds, cost, path, tuple(hits))
            for row, col, cost, path, hits in zip(
                lines, columns, joules, rows, contacts, strict=True
            )
        ]

    def _substeps_in(self, name: str, seconds: float) -> int:
        return max(1, round(real_number(name, seconds, above=True) / self.spec.time_step))

    def _driven(self) -> Driver:
        if self._driver is None:
            raise RuntimeError("the motion needs a reset() before it")
        return self._driver
