"""The robots of one warehouse in a space, each with a motor, a heading and a floor that drags."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pymunk

from warehouse_core import Cell, Layout
from warehouse_physics.arena import ITERATIONS, LONE_BIAS, Arena, Hit
from warehouse_physics.disturbances import FloorConditions
from warehouse_physics.robot import Robot
from warehouse_physics.spec import ARRIVED, RobotSpec
from warehouse_physics.walls import wall_boxes
from warehouse_physics.wheeled_robot import WheeledRobot


class RobotArena(Arena):
    """An arena with the walls of a layout and ``R`` robots, which start in ``cells``."""

    def __init__(
        self,
        layout: Layout,
        cells: Sequence[Cell],
        spec: RobotSpec,
        floor: FloorConditions | None = None,
    ) -> None:
        is_lone = len(cells) == 1
        iterations = ITERATIONS if is_lone else iterations_for_jams(spec)
        super().__init__(spec, max(iterations, iterations_for_drag(spec)))
        if is_lone:
            self.space.collision_bias = LONE_BIAS
        self.add_walls(wall_boxes(layout))
        kind = WheeledRobot if spec.is_differential else Robot
        self.robots = [kind(self, spec, cell, floor) for cell in cells]
        self._varies = floor is not None and floor.varies
        self._touching: set[tuple[int, int]] = set()  # pairs of robots

    def run(self, now: int, until: int, every: int, look: Callable[[int], object]) -> int:
        """Step from substep ``now`` to ``until`` or to the first hit, and return the last substep.

        Robots that take part in a hit react to it before this returns. It returns, or calls
        ``look``, at least once in ``every`` substeps.
        """
        hits: list[Hit] = []
        if len(self.robots) > 1 or self._varies:
            until = min(until, now + every)
        else:
            now, hits = self.stepper.run(now, until, every, look)
            if not hits:
                return now
        while now < until and not hits:
            # Work while others push, and floors that differ, have to be looked at in each substep.
            pushed = {each: self.bodies[each].velocity for each in self._pushed()}
            is_watched = bool(pushed) or self._varies
            now, hits = self.stepper.run(now, now + 1 if is_watched else until)
            for each in pushed.keys() - {hit.robot for hit in hits}:
                self.robots[each].count_push(pushed[each])
            if self._varies:
                for robot in self.robots:
                    robot.feel_floor()
        for hit in hits:
            self.robots[hit.robot].meet(
                now, hit, None if hit.other is None else self.robots[hit.other]
            )
        self._touching |= {(hit.robot, hit.other) for hit in hits if hit.other is not None}
        return now

    def _pushed(self) -> set[int]:
        """Return the robots whose work counts and that still touch a robot which they have hit."""
        reach, pushed = 2 * self._spec.body_radius, set[int]()
        for pair in tuple(self._touching):
            counting = [robot for robot in pair if self.robots[robot].is_counting()]
            if counting:
                one, other = (self.bodies[robot].position for robot in pair)
                if one.get_distance(other) < reach:
                    pushed.update(counting)
                else:
                    self._touching.remove(pair)
        return pushed

    def _mass(self, robot: int, normal: pymunk.Vec2d) -> float:
        """Return the mass in kg with which a robot resists a push along ``normal``."""
        return self.robots[robot].mass_along(normal)


def iterations_for_jams(spec: RobotSpec) -> int:
    """Return the solver iterations that several robots of this kind need: 5 for the default robot.

    The solver converges more slowly for robots that push each other the more their masses differ.
    With 5 iterations for all kinds, about one in 20,000 robots in jams with heavy loads stays
    stuck.
    """
    return 3 + math.ceil(spec.total_mass(loaded=True) / spec.mass)


def iterations_for_drag(spec: RobotSpec) -> int:
    """Return the solver iterations that a robot of this kind needs in order to overcome its drag.

    In each iteration the motor undoes what the drag did in the iteration before, and the other way
    round. Each of them can grow by at most the momentum of the commanded speed in an iteration, so
    a low speed needs many iterations. The lowest speed is commanded to correct an error of
    ``ARRIVED``.
    """
    slowest = math.sqrt(spec.attainable_acceleration(loaded=True) * ARRIVED * spec.cell_size)
    return 3 + math.ceil(spec.floor_deceleration * spec.time_step / slowest)
