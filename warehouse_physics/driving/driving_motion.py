"""The driving backend: robots of a fleet that drive through the cells of their routes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_core import BackendError, Cell, Episode, Layout, Outcome
from warehouse_core.arguments import instance_of, real_number, whole_number
from warehouse_core.motion.base import (
    Contact,
    Routes,
    centre_of,
    check_moves,
    check_starts,
    conditions_of,
)
from warehouse_core.motion.traffic import check_joint_step, find_stops
from warehouse_core.world.tiles import moved
from warehouse_physics.arena import ITERATIONS
from warehouse_physics.body_motion import PATH_EVERY, BodyMotion
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.driving.driven_episode import drive_cells, telling
from warehouse_physics.driving.driver import Driver
from warehouse_physics.driving.leaders import corner_distance
from warehouse_physics.driving.limits import CORNER
from warehouse_physics.driving.wheels import WheeledArena
from warehouse_physics.energy import joules_of, kinetic
from warehouse_physics.exclusive import exclusive
from warehouse_physics.spec import RobotSpec
from warehouse_physics.walls import wall_boxes

MAX_CALL_SUBSTEPS = 100_000
"""Largest number of substeps of a call, nearly half an hour at 1/60 s; its paths take memory."""


class DrivingMotion(BodyMotion):
    """Moves ``R`` robots as bodies that drive through the cells of their routes.

    Each robot has a route ahead of it, and a displacement appends a cell to its end. Robots pass
    each cell in the order in which it was appended to their routes; see ``Dependencies``. A robot
    stops where its route ends or turns back, where it has to wait for another robot, and with
    ``turn_seconds`` at each corner, to turn on the spot. A call lasts ``period`` seconds, whatever
    the robots do. Robots that are driving at its end drive on in the next call. For a plan that is
    already known, ``extend`` and ``drive`` do the two parts of a call.

    The ``cell`` of an outcome is the one under the body, and its ``contacts`` are hits of the body.
    ``blocked`` belongs to the plan: it means that a route had room for a displacement but was not
    extended by it. A body cannot report this. It is a cell or more behind the end of its route, so
    it touches nothing there at the time of the refusal. Later, no wall stops it on its route, and
    it keeps away from its leaders. The table of ``motion/traffic.py`` decides instead, as if the
    robots were at the ends of their routes. No robot can enter a cell that a failed robot closes.

    Args:
        spec: numbers of the robots; ``None`` is the default robot.
        disturbances: deviations from the nominal physics; ``None`` is no deviation.
        period: duration of a call in seconds; ``None`` is the time for one cell at top speed. With
            shorter calls, routes grow further ahead of the robots, so that robots learn of corners
            before they have to brake there. Picking and dropping take ``dwell`` even then.
        record_path: true to record the path of each robot, and not only its start and end.
        path_every: substeps between two rows of a path, at least 1.

    Attributes:
        cell_steps: number of calls in which a robot crosses one cell at top speed.

    Raises:
        ValueError: ``period`` is not above 0 or is too long, or the robots are too wide to follow
            each other.
        TypeError: ``spec`` is not a ``RobotSpec``, or ``disturbances`` not a ``Disturbances``.

    Example:
        >>> from warehouse_core import FleetEnv
        >>> from warehouse_physics import DrivingMotion
        >>> env = FleetEnv(robots=2, starts=[(1, 1), (5, 1)], backend=DrivingMotion())
        >>> observations, info = env.reset()
        >>> step = env.step(["E", "E"])
        >>> env.routes
        Routes(ends=[(1, 2), (5, 2)], has_room=[True, True], at_rest=[False, False], ...
    """

    BODIES = "_driver"
    NUMBERS = ("period",)
    drives_through = True

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        period: float | None = None,
        record_path: bool = True,
        path_every: int = PATH_EVERY,
    ) -> None:
        super().__init__(spec, disturbances, record_path=record_path, path_every=path_every)
        corner_distance(self.spec)
        cell_seconds = self.cell_size / self.spec.top_speed
        # A robot does not stop in each cell, but it speeds up again now and then.
        work = kinetic(self.spec.mass, self.spec.top_speed, 0.0)
        work += self.spec.drag_force(loaded=False) * self.cell_size
        self.cell_joules = joules_of(self.spec, work, cell_seconds)
        self._substeps = self._substeps_in("period", cell_seconds if period is None else period)
        self.period = self._substeps * self.spec.time_step
        self.cell_steps = cell_seconds / self.period
        # With a shorter route ahead, a robot would have to brake before the end of the next call.
        self._room = (
            self.period + self.spec.top_speed / (2 * self.spec.acceleration)
        ) / cell_seconds
        # With short calls, a robot may learn of a corner in time to turn while it drives. Picking
        # and dropping then take longer than one call.
        self._handling = 0
        if self.cell_steps > 1:
            self._room += 0.0 if self.spec.turns_on_the_spot else CORNER
            self._handling = max(0, round(self.spec.dwell / self.spec.time_step) - self._substeps)
        self._layout: Layout | None = None
        self._driver: Driver | None = None

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Create a new arena with robots at rest; see ``Motion.reset``.

        Raises:
            ValueError: a stop in the disturbances names a robot that does not exist.
        """
        check_starts(layout, cells)
        for stop in self.disturbances.stops:
            if stop.robot >= len(cells):
                raise ValueError(f"{stop}: its robot must be at most {len(cells) - 1}")
        self._layout = layout
        kind = WheeledArena if self.spec.is_differential else DrivenArena
        arena = kind(self.spec, ITERATIONS)
        arena.add_walls(wall_boxes(layout))
        arena.add_robots(centre_of(cell, self.cell_size) for cell in cells)
        random_seed = self._random_seed(seed)
        # Energy that is recovered beyond the cost of a call pays for the next calls.
        self._surplus = np.zeros(len(cells))
        self._driver = Driver(arena, self.spec, cells, self.disturbances, random_seed)
        self._begin(layout, cells, random_seed)

    def routes(self) -> Routes:
        """Return the route ahead of each robot; see ``BaseMotion.routes``."""
        driver = self._driver_in_use()
        ends = [driver.routes.end(robot) for robot in range(len(driver.work))]
        return Routes(
            ends,
            ((driver.remaining() <= self._room) & ~driver.stopped).tolist(),
            driver.at_rest().tolist(),
            driver.failed.tolist(),
            sorted(driver.closed),
        )

    def fail(self, robot: int) -> None:
        """Make a robot stay where it is for good; see ``BaseMotion.fail``."""
        driver = self._driver_in_use()
        robot = whole_number("robot", robot, 0, len(driver.work) - 1)
        driver.fail(robot)
        self._note("fail", robot)

    @exclusive
    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Extend the routes by displacements, and drive for one period; see ``Motion.advance``.

        A route that is long enough has no room and is not extended.

        Raises:
            RuntimeError: it is called before ``reset``, or while another call is running.
        """
        driver = self._driver_in_use()
        assert self._layout is not None
        check_moves(len(driver.work), displacements, loaded)
        self._note_moves(displacements, loaded)
        ends, room, _, _, closed = self.routes()
        wanted = [
            moved(end, displacement) if has_room else end
            for end, displacement, has_room in zip(ends, displacements, room, strict=True)
        ]
        open_to = [
            end if target in closed else target for end, target in zip(ends, wanted, strict=True)
        ]
        stops = find_stops(self._layout, ends, open_to)
        targets = [
            target if stop is None else end
            for end, target, stop in zip(ends, open_to, stops, strict=True)
        ]
        driver.load(loaded, self._handling)
        driver.extend(targets)
        return [
            outcome._replace(blocked=target != other)
            for outcome, target, other in zip(
                self._drive(self._substeps), targets, wanted, strict=True
            )
        ]

    @exclusive
    def extend(self, cells: Sequence[Cell]) -> None:
        """Extend the routes by a joint step of a plan, whether they have room or not.

        Args:
            cells: next cell of each robot, or the end of its route if it waits.

        Raises:
            ValueError: there is not one cell per robot, robots cannot make this step (see
                ``check_joint_step``), or a robot that moves has failed or would enter a cell that a
                failed robot closes. The routes are then unchanged.
            RuntimeError: as for ``advance``.
        """
        ends, _, _, failed, closed = self.routes()
        assert self._layout is not None
        check_joint_step(self._layout, ends, cells)
        for robot, (end, cell) in enumerate(zip(ends, cells, strict=True)):
            if cell != end and (failed[robot] or cell in closed):
                why = "it has failed" if failed[robot] else "a robot that has failed closes it"
                raise ValueError(f"robot {robot} cannot go from {end} to {cell}; {why}")
        self._driver_in_use().extend(cells)
        self._note("extend", list(cells))

    @exclusive
    def drive(self, seconds: float) -> list[Outcome]:
        """Drive for some seconds, rounded to substeps, and return the outcome of each robot.

        Raises:
            ValueError: ``seconds`` is not above 0 or is too long.
            RuntimeError: as for ``advance``.
        """
        substeps = self._substeps_in("seconds", seconds)
        self._driver_in_use()
        self._note("drive", seconds)
        return self._drive(substeps)

    def drive_episode(self, episode: Episode) -> Episode:
        """Return a record in which this body drives the cells of a lone robot in one go.

        The robot stops only to pick, drop or wait, where its path turns back, and where it has to
        turn on the spot. All else in the record is unchanged. The ``motions`` of the steps follow
        one another without a gap. A step that did not move the robot, such as a move into a wall,
        takes one substep, because a robot that knows its path does not try it.

        Args:
            episode: record of one robot, on any backend.

        Raises:
            BackendError: the record has several robots, a step leads to a cell that is not a
                neighbour, because the recorded body slid, or disturbances keep the robot from
                arriving.

        Example:
            >>> from agents import GreedyAgent
            >>> from warehouse_core import WarehouseEnv, record_episode
            >>> from warehouse_physics import DrivingMotion
            >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
            >>> driven = DrivingMotion().drive_episode(episode)
            >>> driven.cells == episode.cells, round(driven.seconds)
            (True, 33)
        """
        if instance_of("episode", episode, Episode).is_fleet:
            raise BackendError("the episode has a fleet; it must have a lone robot")
        motion = DrivingMotion(self.spec, self.disturbances, period=self.spec.dwell, path_every=1)
        outcomes = drive_cells(motion, episode)
        settings = replace(
            episode.settings,
            backend=type(self).__name__,
            cell_size=self.cell_size,
            **conditions_of(self, episode.layout)._asdict(),
        )
        return replace(episode, settings=settings, motions=outcomes)

    def close(self) -> None:
        """Release the arena; see ``Motion.close``."""
        self._driver = self._begun = None

    def _drive(self, substeps: int) -> list[Outcome]:
        driver, dt = self._driver_in_use(), self.spec.time_step
        before, paths = driver.joules(), [driver.rows(0.0)]
        contacts: list[list[Contact]] = [[] for _ in before]
        path_every = self._path_every if self._record_path else substeps
        if self._record_path and len(before) == 1:
            path_every = 1  # thinned out below
        for substep in range(1, substeps + 1):
            for hit in driver.step():
                contacts[hit.robot].append(hit.contact(substep * dt))
            if substep == substeps or substep % path_every == 0:
                paths.append(driver.rows(substep * dt))
        seconds, rows = substeps * dt, np.stack(paths, axis=1)
        if len(before) == 1:
            rows = rows[:, telling(rows[0], self._path_every)]
        costs = joules_of(self.spec, rows[:, :, -1] - before[:, None], rows[:, :, 0])
        costs -= self._surplus[:, None]
        self._surplus = np.maximum(-costs[:, -1], 0.0)
        rows[:, :, -1] = np.maximum(costs, 0.0)
        rows.flags.writeable = False
        joules = rows[:, -1, -1].tolist()
        columns, lines = np.floor(driver.positions / self.cell_size).astype(int).T.tolist()
        return self._measured(
            [
                Outcome(
                    (row, col), False, seconds, cost, each[:, :4], tuple(hits),
                    readings=each[:, 4:],
                )
                for row, col, cost, each, hits in zip(
                    lines, columns, joules, rows, contacts, strict=True
                )
            ]
        )  # fmt: skip

    def _substeps_in(self, name: str, seconds: float) -> int:
        dt = self.spec.time_step
        return max(1, round(real_number(name, seconds, 0, MAX_CALL_SUBSTEPS * dt, above=True) / dt))

    def _driver_in_use(self) -> Driver:
        if self._driver is None:
            raise RuntimeError("the motion needs a reset() before it")
        return self._driver
