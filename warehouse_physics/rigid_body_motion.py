"""The physics backend for moves from cell to cell, in which robots stop in each cell."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.motion.base import check_directions, check_moves, check_starts
from warehouse_physics.batch.rigid_body_batch import RigidBodyBatch
from warehouse_physics.body_motion import PATH_EVERY, BodyMotion
from warehouse_physics.disturbances import Disturbances, FloorConditions
from warehouse_physics.energy import joules_of
from warehouse_physics.exclusive import exclusive
from warehouse_physics.giving_way import GivingWay
from warehouse_physics.phases import NEVER, REST
from warehouse_physics.robot import MAX_SECONDS, BodyRow, Robot
from warehouse_physics.robot_arena import RobotArena
from warehouse_physics.spec import (
    MAX_FLEET_RADIUS,
    MAX_MOVE_SECONDS,
    MAX_WHEELED_RADIUS,
    RobotSpec,
)

STAY = (0, 0)


class RigidBodyMotion(BodyMotion):
    """Moves ``R`` robots as discs with mass, which motors of finite force drive and which collide.

    Nothing is looked up in the grid. The ``cell`` of an outcome is the one under the body, and a
    robot is blocked because Chipmunk reports that it touched something. It then drives back to the
    middle of its cell. If several robots block each other, they give way as in ``giving_way.py``.
    All robots accelerate like the slowest one, such as a loaded robot. The ``seconds`` of each
    robot end when it is at rest.

    Robots with ``turn_seconds`` first turn on the spot, in the shorter direction, and drive back in
    reverse. All moving robots set off at the same time, after the longest turn of any of them. A
    robot that follows another, or is part of a ring, needs the others to leave at the same time.
    Robots that turn less turn more slowly. Robots with differential drive set off together too, but
    each turns as fast as it can and then waits; see ``wheeled_robot.py``.

    In a fleet with headings, robots can turn in their cells while others drive; see ``face``.

    Args:
        spec: numbers of the robots; ``None`` is the default robot.
        disturbances: deviations from the nominal physics; ``None`` is no deviation.
        record_path: true to record the path of each robot, and not only its start and end.
        path_every: substeps between two rows of a path, at least 1.

    Raises:
        ValueError: ``path_every`` is below 1, or the disturbances have stops, which only
            ``DrivingMotion`` supports.
        TypeError: ``path_every`` is not an integer, ``spec`` not a ``RobotSpec``, or
            ``disturbances`` not a ``Disturbances``.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_physics import RigidBodyMotion, RobotSpec
        >>> env = WarehouseEnv(backend=RigidBodyMotion(RobotSpec(top_speed=2.0)))
        >>> observation = env.reset()
        >>> step = env.step("E")
        >>> env.last_motion.cell, round(env.last_motion.seconds, 2)
        ((1, 2), 2.0)
    """

    BODIES = "_arena"

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        record_path: bool = True,
        path_every: int = PATH_EVERY,
    ) -> None:
        super().__init__(spec, disturbances, record_path=record_path, path_every=path_every)
        if self.disturbances.stops:
            raise ValueError(
                f"stops is {self.disturbances.stops}; it must be empty for robots that stop in "
                "each cell; only DrivingMotion supports stops"
            )
        self.spec = self.spec.refined(self.disturbances.highest_speed(self.spec.top_speed))
        self._accelerations = [
            self.spec.attainable_acceleration(loaded) for loaded in (False, True)
        ]
        self._arena: RobotArena | None = None
        self._facing: Sequence[Cell] = ()

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Create a new arena with robots at rest; see ``Motion.reset``.

        Raises:
            ValueError: there are several robots and their radius is above ``MAX_FLEET_RADIUS`` of a
                cell, or with differential drive above ``MAX_WHEELED_RADIUS``.
        """
        check_starts(layout, cells)
        share = MAX_WHEELED_RADIUS if self.spec.is_differential else MAX_FLEET_RADIUS
        widest = share * self.cell_size
        if len(cells) > 1 and self.spec.radius > widest:
            raise ValueError(
                f"radius is {self.spec.radius!r}; with cell_size {self.cell_size!r} it must be at "
                f"most {widest!r} for {len(cells)} robots, which pass each other at corners"
            )
        random_seed = self._random_seed(seed)
        floor = (
            FloorConditions(self.disturbances, random_seed) if self.disturbances.is_felt else None
        )
        self._arena, self._facing = RobotArena(layout, cells, self.spec, floor), ()
        self._begin(layout, cells, random_seed)

    @exclusive
    def face(self, directions: Sequence[Cell]) -> None:
        """Make robots turn on the spot in the next ``advance``; see ``BaseMotion.face``."""
        if self._arena is None:
            raise RuntimeError("face() needs a reset() before it")
        check_directions(len(self._arena.robots), directions)
        self._facing = tuple(directions)
        self._note("face", self._facing)

    @exclusive
    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Carry out one action of each robot; see ``Motion.advance``.

        Raises:
            RuntimeError: it is called before ``reset``, or while another call is running.
        """
        if self._arena is None:
            raise RuntimeError("advance() needs a reset() before it")
        robots = self._arena.robots
        check_moves(len(robots), displacements, loaded)
        self._note_moves(displacements, loaded)
        moves = zip(displacements, loaded, strict=True)
        acceleration = self._accelerations[
            any(load and displacement != STAY for displacement, load in moves)
        ]
        turning = max(
            robot.begin(displacement, load, acceleration)
            for robot, displacement, load in zip(robots, displacements, loaded, strict=True)
        )
        for robot in robots:
            robot.set_off(turning)
        facing, self._facing = self._facing, ()
        for robot, direction in zip(robots, facing, strict=False):
            if direction != STAY and robot.action.goal == robot.action.home:
                robot.turn_to(direction)
        paths = [[robot.row(0.0)] for robot in robots]
        substeps = self._drive(self._arena, paths)
        return self._measured(
            [self._outcome(*each, substeps) for each in zip(robots, paths, strict=True)]
        )

    def batch(self, layouts: Sequence[Layout]) -> RigidBodyBatch:
        """Return a motion for one robot in each of these layouts; see ``BaseMotion.batch``.

        Raises:
            ValueError: there are no layouts, or this motion has disturbances, which a batch does
                not support.
        """
        if self.disturbances.any:
            raise ValueError(
                f"{self.disturbances} cannot be batched; a batch does not support disturbances"
            )
        return RigidBodyBatch(self.spec, layouts)

    def close(self) -> None:
        """Release the arena; see ``Motion.close``."""
        self._arena = self._begun = None

    def _drive(self, arena: RobotArena, paths: list[list[BodyRow]]) -> int:
        """Run until all robots are at rest, and return the number of substeps."""
        now = 0
        robots = arena.robots
        giving_way = GivingWay(robots) if len(robots) > 1 else None
        # In the worst case, robots drive one after the other.
        seconds = MAX_SECONDS + (len(robots) - 1) * MAX_MOVE_SECONDS
        limit = math.ceil(seconds / self.spec.time_step)
        path_every = self._path_every if self._record_path else limit

        look = _recorder(robots, paths, self.spec.time_step)
        while now < limit:
            until = min([robot.until for robot in robots])
            if until == NEVER:
                if giving_way is None or not giving_way.move_on(now):
                    break
                continue
            now = arena.run(now, until, path_every, look)
            if self._record_path:
                look(now)
            for robot in robots:
                if robot.until <= now:
                    robot.next_phase(now)
        return now

    def _outcome(self, robot: Robot, path: list[BodyRow], substeps: int) -> Outcome:
        action, cut_off = robot.action, robot.phase != REST
        if cut_off:
            robot.halt(substeps)
        seconds = (substeps if cut_off else action.rested) * self.spec.time_step
        if action.goal == action.home:
            seconds = max(seconds, self.spec.dwell)
        # With recuperation, a push by another robot may return more energy than the action costs.
        joules = max(joules_of(self.spec, action.work, seconds), 0.0)
        robot.look()  # another robot may have pushed it
        if path[-1][0] < seconds:
            path.append(robot.row(seconds))
        path[-1] = *path[-1][:-1], joules
        rows = np.array(path)
        rows.flags.writeable = False
        cell, blocked, contacts = robot.cell, robot.is_blocked(), tuple(action.contacts)
        return Outcome(cell, blocked, seconds, joules, rows[:, :4], contacts, cut_off, rows[:, 4:])


def _recorder(
    robots: Sequence[Robot], paths: Sequence[list[BodyRow]], time_step: float
) -> Callable[[int], None]:
    """Return a function that appends the row after a substep to the path of each moving robot."""
    if len(robots) == 1:  # without a loop, it takes half as long
        [robot], [path] = robots, paths

        def look_at_it(substep: int) -> None:
            robot.look()
            path.append(robot.row(substep * time_step))

        return look_at_it

    def look(substep: int) -> None:
        for robot, path in zip(robots, paths, strict=True):
            if robot.phase != REST:
                robot.look()
                path.append(robot.row(substep * time_step))

    return look
