"""Drives ``R`` robots along their ways, in the order in which they are to pass each cell.

A way is a sequence of neighbouring cells, numbered as in ``Dependencies``. A robot drives straight
runs of it, *legs*; a leg grows while it is driven. Round a corner a robot begins its next leg while
it still brakes, and stops only where its way ends or turns back, or for its leaders. A robot that
has to turn on the spot stops at corners too, and turns as soon as its next leg is known.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import islice

import numpy as np

from warehouse_core import Cell
from warehouse_core.motion.base import centre_of
from warehouse_core.world.tables import Flags
from warehouse_physics.arena import Hit
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.driving.dependencies import Dependencies
from warehouse_physics.driving.headings import Headings
from warehouse_physics.driving.leaders import Leaders
from warehouse_physics.driving.limits import Limits
from warehouse_physics.driving.motors import Motors
from warehouse_physics.driving.wheels import WheeledArena, WheelHeadings
from warehouse_physics.energy import regained, spent
from warehouse_physics.profile import Floats, stopping_distances, stopping_speeds
from warehouse_physics.spec import ARRIVED, RobotSpec

NEAR = 0.02
"""Share of a cell beyond the middle of a cell in which a robot is still at its middle."""

SLOW = 1e-3
"""Speed in m/s below which a robot may begin another leg."""


class Driver:
    """Drives the robots of an arena, which are at rest in their cells.

    Attributes:
        ways: cells that the robots are to drive through.
        positions: ``[R, 2]`` metres.
        stands: ``[R]`` bool, true if a robot has stopped and cannot drive.
        failed: ``[R]`` bool, true if a robot will never drive again.
        closed: cells that failed robots are in, or reach into.
        work: ``[R]`` joules, work of each motor in drives so far.
    """

    def __init__(
        self,
        arena: DrivenArena,
        spec: RobotSpec,
        cells: Sequence[Cell],
        disturbances: Disturbances,
        seed: int,
    ) -> None:
        robots = len(cells)
        self._arena, self._spec = arena, spec
        self._size, self._dt = spec.cell_size, spec.time_step
        self.ways, self._limits = Dependencies(cells), Limits(spec, robots, disturbances)
        self._motors = Motors(arena, spec, self._limits, disturbances, seed)
        self._slippery = disturbances.slippery
        self._stops, self._substep = disturbances.stops, 0
        self.stands, self.failed = np.zeros((2, robots), np.bool_)
        self.closed: set[Cell] = set()
        self._leaders = Leaders(spec, self.ways, self._limits)
        self._headings = (
            WheelHeadings(spec, arena, self._motors, self._limits)
            if isinstance(arena, WheeledArena)
            else Headings(spec, robots)
        )
        # The present legs: numbers of the first and last node, the middle of the first node, the
        # direction, and whether the way turns left or right at the last node.
        self._starts, self._ends = np.zeros((2, robots), np.int64)
        self._origins = np.array([centre_of(cell, self._size) for cell in cells])
        self._along = np.tile((1.0, 0.0), (robots, 1))
        self._has_corner = np.zeros(robots, np.bool_)
        self._lasts = np.zeros(robots, np.int64)  # nodes of the whole ways
        self.work = np.zeros(robots)
        self._motors.load()
        self._look()

    def load(self, loaded: Sequence[bool]) -> None:
        """Set which robots carry items."""
        now = np.array(loaded)
        if (now != self._limits.loaded).any():
            self._limits.load(now)
            self._motors.load()

    def extend(self, targets: Sequence[Cell]) -> None:
        """Append a joint step to the ways; see ``Dependencies.extend``."""
        movers = self.ways.extend(targets)
        if self._slippery:
            self._expect_slips(movers)
        for robot in movers:
            last = self._lasts[robot] = self.ways.last(robot)
            if self._ends[robot] == last - 1:
                self._end_leg(robot)
            self._leaders.find(robot, self._done)

    def scan(self, robot: int, rays: int) -> Floats:
        """Return what a robot sees; see ``Senses``."""
        return self._arena.scan(robot, rays)

    def at_rest(self) -> Flags:
        """Return whether each robot is at rest at the end of its way, ``[R]``."""
        is_last: Flags = self._ends == self._lasts
        return self._have_arrived() & is_last & ~self.stands

    def left(self) -> Floats:
        """Return how many cells of its way each robot has yet to go, ``[R]``."""
        return self._lasts - self._done / self._size

    def joules(self) -> Floats:
        """Return the work of the motor of each robot so far, in drives and turns, ``[R]``."""
        return self.work + self._headings.work

    def rows(self, seconds: float) -> Floats:
        """Return a row of the path of each robot, ``[R, 4]``; see ``Outcome``."""
        headings = self._headings.angles
        return np.column_stack([np.full(len(headings), seconds), self.positions, headings])

    def step(self) -> list[Hit]:
        """Drive for one substep, and return the hits that begin in it."""
        self._stop()
        for robot in (self._may_turn() & (self._ends < self._lasts)).nonzero()[0].tolist():
            self.ways.forget(robot, int(self._ends[robot]))
            self._set_leg(robot, int(self._ends[robot]))
        self._leaders.drop(self._done)
        across = self._along[:, ::-1] * (-1.0, 1.0)
        turns, aside = self._turning(), self._choose_speeds_aside(across)
        speeds = self._choose_speeds(turns)
        before, aside = self._speeds, self._headings.steer(aside, speeds)
        chosen = speeds[:, None] * self._along + aside[:, None] * across
        self._arena.command(self._motors.command(chosen, speeds, before, turns))
        _, hits = self._arena.stepper.run(0, 1)
        self._look()
        gained = self._limits.masses * (self._speeds**2 - before**2) / 2
        work = gained + self._motors.drags * np.abs(before) * self._dt
        self.work += spent(work)
        if self._spec.recuperation:
            work[[hit.robot for hit in hits]] = 0.0  # what a hit takes from a robot is lost
            self.work -= regained(self._spec, work)
        return hits

    def _look(self) -> None:
        """Read how far each robot is on its way, and how fast."""
        self.positions, self._velocities = self._arena.look()
        self._offsets = self.positions - self._origins
        self._done = self._starts * self._size + _dots(self._offsets, self._along)
        self._speeds = _dots(self._velocities, self._along)
        entered = self._motors.feel(self.positions)
        if self._slippery and entered:
            self._expect_slips(range(len(self.stands)))

    def _have_arrived(self) -> Flags:
        """Return whether each robot is at rest at the end of its leg."""
        off = np.abs(self._ends * self._size - self._done)
        has_arrived: Flags = (off <= ARRIVED * self._size) & (np.abs(self._speeds) <= SLOW)
        return has_arrived

    def _may_turn(self) -> Flags:
        """Return whether each robot may begin its next leg: from rest, or round a corner."""
        limits = self._limits
        is_near = self._ends * self._size - self._done <= limits.corner
        is_slow = self._speeds <= limits.corner_speeds + SLOW
        is_free = self._leaders.nodes[:, 0] > self._ends
        is_turning: Flags = self._has_corner & is_near & is_slow & is_free
        return (self._have_arrived() | is_turning) & ~self.stands

    def _turning(self) -> Flags:
        """Return whether each robot is off the line of its leg, ``[R]``."""
        x, y = self._offsets.T
        aside = np.abs(x * self._along[:, 1] - y * self._along[:, 0])
        is_off: Flags = aside > ARRIVED * self._size
        return is_off

    def _choose_speeds(self, turns: Flags) -> Floats:
        """Return the speeds along their legs that the robots are to have next, ``[R]`` m/s.

        Robots that ``turns`` marks are off the lines of their legs.
        """
        limits, dt, is_exact = self._limits, self._dt, self._motors.is_exact
        ups, downs = (
            np.where(turns, limits.corner_rates, rates) for rates in (limits.ups, limits.downs)
        )
        ahead = self._done + self._speeds * dt
        left = self._ends * self._size - ahead
        is_before, spare = left > 0, np.where(self._has_corner, limits.spare, 0.0)
        wanted = stopping_speeds(np.where(is_before, left - spare, -left), downs, dt)
        wanted = np.where(is_before, wanted, -wanted)
        fastest = self._motors.fastest(self._speeds, np.where(self._speeds < 0, downs, ups))
        speeds: Floats = np.minimum(wanted, fastest) if is_exact else wanted
        stands = self._headings.turn(self.stands)
        if stands.any():
            # Robots that drive otherwise than they are commanded brake as hard as they can.
            slower = np.maximum(np.abs(self._speeds) - downs * dt, 0.0) if is_exact else 0.0
            speeds = np.where(stands, np.sign(self._speeds) * slower, speeds)
        self._leaders.slow_down(speeds, ahead, downs, None if is_exact else self._speeds)
        if not is_exact:
            speeds = np.minimum(speeds / self._motors.excess(self._speeds), fastest)
        return speeds

    def _choose_speeds_aside(self, across: Floats) -> Floats:
        """Return the speeds at which they are to get back to the lines of their legs, ``[R]``."""
        aside = _dots(self._offsets + self._velocities * self._dt, across)
        speeds = stopping_speeds(np.abs(aside), self._limits.corner_rates, self._dt)
        return -np.sign(aside) * speeds

    def _stop(self) -> None:
        """Let robots stop that are to stand now, and others drive on."""
        if self._stops:
            now = self._substep * self._dt
            self._substep += 1
            self.stands = self.failed.copy()
            for stop in self._stops:
                if stop.at <= now < stop.at + stop.seconds:
                    self.stands[stop.robot] = True
                    if stop.seconds == math.inf and not self.failed[stop.robot]:
                        self.fail(stop.robot)

    def fail(self, robot: int) -> None:
        """Let a robot brake and stay where it is, and others go on without it.

        So do those that could only go back to where a failed robot reaches into their ways: they
        are caught between robots, with no cell to come to rest in.
        """
        self.failed[robot] = self.stands[robot] = True
        size, apart = self._size, self._leaders.apart
        nearest, farthest = self._rests()
        reached = np.minimum(np.ceil(farthest / size - NEAR), self._lasts).astype(int)
        number = min(int(nearest[robot] // size), int(self._lasts[robot]))
        if number < self._lasts[robot]:
            number += bool(nearest[robot] - number * size >= apart + NEAR * size)
            is_between = farthest[robot] > (number + 1) * size - apart
            reached[robot] = min(number + is_between, int(self._lasts[robot]))
        self.closed |= {
            self.ways.node(robot, each).cell for each in range(number, reached[robot] + 1)
        }
        for each, goes_back in self.ways.cut(robot, number, reached.tolist()).items():
            self._lasts[each] = last = self.ways.last(each)
            if goes_back:
                self._set_leg(each, self.ways.first(each))
            elif self._ends[each] >= last:
                self._ends[each], self._has_corner[each] = last, False
        self._lasts[robot] = number
        for each in range(len(self.stands)):
            self._leaders.find_anew(each, self._done)
        if self._slippery:
            self._expect_slips(range(len(self.stands)))
        for each in range(len(self.stands)):
            ahead = self.ways.nodes(each, int(self._done[each] // size) + 1)
            if not self.failed[each] and any(node.cell in self.closed for _, node in ahead):
                self.fail(each)

    def _rests(self) -> tuple[Floats, Floats]:
        """Return the least and the most of its way that each robot will have done if it brakes."""
        limits = self._limits
        downs = np.where(self._turning(), limits.corner_rates, limits.downs)
        stops = (
            np.sign(self._speeds) * stopping_distances(np.abs(self._speeds), rates, self._dt)
            for rates in (limits.hardest, downs)
        )
        hardest, gentlest = (self._done + each for each in stops)
        return np.minimum(hardest, gentlest), np.maximum(hardest, gentlest)

    def _expect_slips(self, robots: Iterable[int]) -> None:
        """Find which robots are on slippery floor, or may be before they could stop."""
        slips = self._limits.slips.copy()
        reach = 2 + int(self._limits.usual_reach / self._size)
        for robot in robots:
            here = int(self._done[robot] // self._size)
            cells = (node.cell for _, node in self.ways.nodes(robot, here - 1))
            slips[robot] = not self._slippery.isdisjoint(islice(cells, reach + 2))
        self._limits.slip(slips)

    def _set_leg(self, robot: int, start: int) -> None:
        """Let a robot drive the straight run of its way that begins at a node."""
        self._starts[robot], self._ends[robot] = start, start + 1
        self._along[robot] = along = np.array(self.ways.move(robot, start + 1)[::-1], float)
        self._origins[robot] = centre_of(self.ways.node(robot, start).cell, self._size)
        self._offsets[robot] = offset = self.positions[robot] - self._origins[robot]
        self._done[robot] = start * self._size + offset @ along
        self._speeds[robot] = speed = self._velocities[robot] @ along
        self._headings.face(robot, along, abs(speed) > SLOW)
        self._motors.turn(robot, speed)
        self._end_leg(robot)

    def _end_leg(self, robot: int) -> None:
        """Let a leg end where the way turns, or ends."""
        along, end = tuple(self._along[robot, ::-1].tolist()), int(self._ends[robot])
        turn = 0.0
        while end < self._lasts[robot]:
            move = self.ways.move(robot, end + 1)
            if move != along:
                turn = along[0] * move[1] - along[1] * move[0]
                break
            end += 1
        self._ends[robot] = end
        self._has_corner[robot] = turn != 0 and not self._headings.on_the_spot


def _dots(some: Floats, others: Floats) -> Floats:
    """Return the dot product of each pair of vectors, ``[R]``; a sum over two columns is slower."""
    return some[:, 0] * others[:, 0] + some[:, 1] * others[:, 1]
