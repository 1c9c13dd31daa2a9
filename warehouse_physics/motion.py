"""The physics backend: every grid move as the motion of a rigid body."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.motion.base import check_moves, check_starts
from warehouse_physics.arena import Arena
from warehouse_physics.disturbances import Disturbances, Floor
from warehouse_physics.robot import MOST_SUBSTEPS, NEVER, Robot
from warehouse_physics.robot_spec import RobotSpec
from warehouse_physics.vector.motion import RigidBodyBatch

Row = tuple[float, float, float, float]

PATH_EVERY = 10
"""Substeps from one row of the path to the next."""

STAY = (0, 0)


class RigidBodyMotion:
    """Moves ``R`` robots as discs with mass, driven by finite force, that collide.

    Nothing is looked up in the grid: ``cell`` is the cell under the body, and a robot is blocked
    because Chipmunk reports that it touched something. It then drives back to the middle of its
    cell. Robots that move at the same time keep the pace of the slowest, as a loaded robot is.

    Args:
        spec: what the robots are made of.
        disturbances: how far the world departs from the nominal.
        record_path: keep the way of each robot; without it a path is its start and its end.
        path_every: substeps from one row of the path to the next, at least 1; ``None`` is
            ``PATH_EVERY``.

    Raises:
        ValueError: ``path_every`` is below 1.
    """

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        record_path: bool = True,
        path_every: int | None = None,
    ) -> None:
        if path_every is not None and path_every < 1:
            raise ValueError(f"path_every is {path_every}; it must be at least 1")
        every = PATH_EVERY if path_every is None else path_every
        self._path_every = every if record_path else MOST_SUBSTEPS
        self.spec = spec or RobotSpec()
        self.disturbances = disturbances or Disturbances()
        self.cell_size = self.spec.cell_size
        self._record_path = record_path
        self._empty_pace = self.spec.attainable_acceleration(loaded=False)
        self._loaded_pace = self.spec.attainable_acceleration(loaded=True)
        self._arena: Arena | None = None

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Build the world anew with robots at rest; see ``Motion.reset``."""
        check_starts(layout, cells)
        floor = None
        if self.disturbances.any:
            # Without a seed chance comes from Python's global stream, as in the chapter.
            floor = Floor(self.disturbances, random.getrandbits(32) if seed is None else seed)
        self._arena = Arena(layout, cells, self.spec, floor)

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Carry out one action for each robot; see ``Motion.advance``."""
        if self._arena is None:
            raise RuntimeError("advance() needs a reset() before it")
        robots = self._arena.robots
        check_moves(len(robots), displacements, loaded)
        pace = self._pace_of(displacements, loaded)
        for robot, displacement, load in zip(robots, displacements, loaded, strict=True):
            robot.set_out(displacement, load, pace)
        paths = [[self._row(0.0, robot)] for robot in robots]
        substeps = self._drive(self._arena, paths)
        seconds = substeps * self.spec.time_step if substeps else self.spec.dwell
        return [self._outcome(*each, seconds) for each in zip(robots, paths, strict=True)]

    def batch(self, layouts: Sequence[Layout]) -> RigidBodyBatch:
        """Return a motion for one robot in each of these layouts; see ``Batchable``.

        Raises:
            ValueError: no layouts, or this motion has disturbances, which a batch does not know.
        """
        if self.disturbances.any:
            raise ValueError(
                f"{self.disturbances} cannot be batched; a batch is nominal, without disturbances"
            )
        return RigidBodyBatch(self.spec, layouts)

    def close(self) -> None:
        """Let the world go; see ``Motion.close``."""
        self._arena = None

    def _pace_of(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> float:
        """Return the acceleration in m/s² that every robot on the move can keep."""
        pace = self.spec.acceleration
        for displacement, load in zip(displacements, loaded, strict=True):
            if load and displacement != STAY:
                pace = self._loaded_pace
        return min(pace, self._empty_pace)

    def _drive(self, arena: Arena, paths: list[list[Row]]) -> int:
        """Run until all robots rest, and return after how many substeps they do."""
        now = 0
        robots = arena.robots
        while now < MOST_SUBSTEPS and (until := min([robot.until for robot in robots])) < NEVER:
            now = arena.run(now, min(until, now + self._path_every))
            if self._record_path:
                seconds = now * self.spec.time_step
                for robot, path in zip(robots, paths, strict=True):
                    robot.look()
                    path.append(self._row(seconds, robot))
            for robot in robots:
                if robot.until <= now:
                    robot.next_phase(now)
        return now

    def _outcome(self, robot: Robot, path: list[Row], seconds: float) -> Outcome:
        robot.look()
        if path[-1][0] < seconds:
            path.append(self._row(seconds, robot))
        rows = np.array(path)
        rows.flags.writeable = False
        joules = robot.work / self.spec.drivetrain_efficiency + self.spec.idle_power * seconds
        return Outcome(robot.cell, robot.gave_up, seconds, joules, rows, tuple(robot.contacts))

    @staticmethod
    def _row(seconds: float, robot: Robot) -> Row:
        x, y = robot.position
        return seconds, x, y, robot.body.angle
