"""Drives ``R`` robots along their routes, in the order in which they have to pass each cell.

A route is a sequence of neighbouring cells, numbered as in ``Dependencies``. A robot drives its
straight parts, the *legs*; the last leg can grow while the robot drives it. At a corner a robot
begins its next leg while it still brakes in the present one. It stops only where its route ends or
turns back, or to wait for its leaders. A robot that has to turn on the spot stops at corners too,
and turns as soon as its next leg is known.

In each substep the driver chooses a speed for each robot: the highest one from which it can still
stop at the end of its leg and behind its leaders, within its acceleration. A robot that has turned
is at first off the line of its new leg. A second speed brings it back to that line.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import islice

import numpy as np

from warehouse_core import Cell
from warehouse_core.motion.base import centre_of
from warehouse_core.world.tables import Flags, Integers
from warehouse_physics.arena import Hit
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.driving.dependencies import Dependencies
from warehouse_physics.driving.headings import Headings
from warehouse_physics.driving.leaders import NOWHERE, Leaders, RoutePlaces
from warehouse_physics.driving.limits import Limits
from warehouse_physics.driving.motors import Motors
from warehouse_physics.driving.wheels import WheeledArena, WheelHeadings
from warehouse_physics.energy import regained, spent, work_in_substep
from warehouse_physics.profile import Floats, lengths_of, stopping_distances, stopping_speeds
from warehouse_physics.spec import ARRIVED, RobotSpec

NEAR = 0.02
"""Distance beyond the middle of a cell at which a robot still counts as in the middle, as a share
of a cell."""

HEADED = 0.05
"""Share of the top speed above which the heading of a disc follows the direction of its motion. At
a lower speed it may be correcting a small error of its position."""

SLOW = 1e-3
"""Speed in m/s below which a robot may begin another leg."""


class Driver:
    """Drives the robots of an arena, which are at first at rest in their cells.

    Attributes:
        routes: routes of the robots, and the order in which they pass each cell.
        positions: ``[R, 2]`` metres.
        stopped: ``[R]`` bool, true while a robot has a failure, so that it brakes and then stays.
        failed: ``[R]`` bool, true if a robot will never drive again.
        closed: cells that failed robots are in or reach into.
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
        self.routes, self._limits = Dependencies(cells), Limits(spec, robots, disturbances)
        self._motors = Motors(arena, spec, self._limits, disturbances, seed)
        self._disturbances = disturbances
        self._stops, self._substep = disturbances.stops, 0
        self.stopped, self.failed = np.zeros((2, robots), np.bool_)
        self.closed: set[Cell] = set()
        self._leaders = Leaders(spec, self.routes, self._limits)
        self._headings = (
            WheelHeadings(spec, arena, self._motors, self._limits)
            if isinstance(arena, WheeledArena)
            else Headings(spec, robots)
        )
        # The present legs: numbers of the first and the last node, middle of the first node,
        # direction, and whether the route turns left or right at the last node.
        self._starts, self._ends = np.zeros((2, robots), np.int64)
        self._origins = np.array([centre_of(cell, self._size) for cell in cells])
        self._along = np.tile((1.0, 0.0), (robots, 1))
        self._has_corner = np.zeros(robots, np.bool_)
        self._lasts = np.zeros(robots, np.int64)  # last nodes of the routes
        # Nodes before which robots turn back when they are at rest, because another one has failed.
        self._backs = np.full(robots, NOWHERE)
        self._handling = np.zeros(robots, np.int64)  # substeps that are left to pick or drop
        self.work = np.zeros(robots)
        self._motors.load()
        self._velocities = np.zeros((robots, 2))
        self._look()

    def load(self, loaded: Sequence[bool], handling: int) -> None:
        """Set which robots carry items.

        A robot that picks or drops its item now needs ``handling`` more substeps for it.
        """
        now = np.array(loaded)
        changes = now != self._limits.loaded
        if changes.any():
            self._handling[changes] = handling
            self._limits.load(now)
            self._motors.load()

    def extend(self, targets: Sequence[Cell]) -> None:
        """Append a joint step to the routes; see ``Dependencies.extend``."""
        movers = self.routes.extend(targets)
        if self._disturbances.slippery:
            self._expect_slips(movers)
        for robot in movers:
            last = self._lasts[robot] = self.routes.last(robot)
            if self._ends[robot] == last - 1:
                self._end_leg(robot)
            self._leaders.find(robot, self._passed)

    def scan(self, robot: int, rays: int) -> Floats:
        """Return the distances that a robot measures; see ``BaseMotion.scan``."""
        return self._arena.scan(robot, rays)

    def at_rest(self) -> Flags:
        """Return whether each robot is at rest at the end of its route, ``[R]``."""
        return self._are_at_ends() & self._are_free()

    def remaining(self) -> Floats:
        """Return the length of the route that each robot has yet to drive, ``[R]`` in cells."""
        return self._lasts - self._done / self._size

    def joules(self) -> Floats:
        """Return the work of each motor so far in J, in drives and in turns, ``[R]``."""
        return self.work + self._headings.work

    def rows(self, seconds: float) -> Floats:
        """Return the present row of the path and of the readings of each robot, ``[R, 9]``.

        The last column has the work so far in J, not yet the energy; see ``Outcome``.
        """
        headings, velocities = self._headings.angles, self._velocities
        speeds = lengths_of(velocities)[:, None]
        self._headings.follow(velocities, speeds[:, 0] > HEADED * self._spec.top_speed)
        drags = self._motors.drags[:, None] * velocities / np.maximum(speeds, SLOW)
        gained = (velocities - self._earlier) / self._dt
        return np.column_stack(
            [
                np.full(len(headings), seconds),
                self.positions,
                headings,
                velocities,
                self._limits.masses[:, None] * gained + drags,
                self.joules(),
            ]
        )

    def step(self) -> list[Hit]:
        """Drive for one substep, and return the hits that begin in it."""
        self._stop()
        for robot in (self._may_turn() & (self._ends < self._lasts)).nonzero()[0].tolist():
            self.routes.forget(robot, int(self._ends[robot]))
            self._set_leg(robot, int(self._ends[robot]))
        self._handling = np.maximum(self._handling - 1, 0)
        self._leaders.drop(self._passed)
        across = self._along[:, ::-1] * (-1.0, 1.0)
        aside = _dots(self._offsets + self._velocities * self._dt, across)
        closing = self._choose_closing(aside, across)
        turns = self._turning()
        speeds = self._choose_speeds(turns, np.abs(aside), closing)
        before, back = self._speeds, self._headings.steer(-np.sign(aside) * closing, speeds)
        chosen = speeds[:, None] * self._along + back[:, None] * across
        self._arena.command(self._motors.command(chosen, speeds, before, turns))
        _, hits = self._arena.stepper.run(0, 1)
        self._look()
        masses, drags = self._limits.masses, self._motors.drags
        work = work_in_substep(masses, before, self._speeds, drags, self._dt)
        self.work += spent(work)
        if self._spec.recuperation:
            work[[hit.robot for hit in hits]] = 0.0  # a hit takes energy that is not recovered
            self.work -= regained(self._spec, work)
        return hits

    def _look(self) -> None:
        """Read the positions and velocities, and update the progress of each robot on its route."""
        self._earlier = self._velocities
        self.positions, self._velocities = self._arena.look()
        self._offsets = self.positions - self._origins
        self._done = self._starts * self._size + _dots(self._offsets, self._along)
        self._speeds = _dots(self._velocities, self._along)
        across = self._along[:, ::-1] * (-1.0, 1.0)
        aside = _dots(self._offsets, across)
        self._aside = np.abs(aside)
        self._closing = np.maximum(-np.sign(aside) * _dots(self._velocities, across), 0.0)
        self._passed = self._done - self._aside
        entered = self._motors.feel(self.positions)
        if self._disturbances.slippery and entered:
            self._expect_slips(range(len(self.stopped)))

    def _are_free(self) -> Flags:
        """Return whether each robot may drive: no failure, no picking, no dropping, ``[R]``."""
        is_free: Flags = ~self.stopped & (self._handling == 0)
        return is_free

    def _are_at_ends(self) -> Flags:
        """Return whether each robot has arrived at the end of its route, ``[R]``."""
        is_last: Flags = self._ends == self._lasts
        return self._have_arrived() & is_last

    def _have_arrived(self) -> Flags:
        """Return whether each robot is at rest at the end of its leg, ``[R]``."""
        off = np.abs(self._ends * self._size - self._done)
        has_arrived: Flags = (off <= ARRIVED * self._size) & (np.abs(self._speeds) <= SLOW)
        return has_arrived

    def _may_turn(self) -> Flags:
        """Return whether each robot may begin its next leg, at rest or at a corner, ``[R]``."""
        limits, speeds = self._limits, self._speeds
        remaining = self._ends * self._size - self._done - speeds * self._dt
        is_near = remaining <= stopping_distances(speeds, limits.corner_rates, self._dt)
        is_slow = speeds <= limits.corner_speeds + SLOW
        is_turning: Flags = self._has_corner & (remaining <= limits.corner) & is_near & is_slow
        if is_turning.any():
            is_turning &= self._leaders.leave(self._ends, self._passed, speeds + self._closing)
        goes_back: Flags = (self._backs == self._ends) & (np.abs(speeds) <= SLOW)
        return (self._have_arrived() | is_turning | goes_back) & self._are_free()

    def _turning(self) -> Flags:
        """Return whether each robot is off the line of its leg, ``[R]``."""
        is_off: Flags = self._aside > ARRIVED * self._size
        return is_off

    def _choose_speeds(self, turns: Flags, aside: Floats, closing: Floats) -> Floats:
        """Return the next speeds of the robots along their legs, ``[R]`` m/s.

        Args:
            turns: ``[R]`` bool, true if a robot is off the line of its leg.
            aside: ``[R]`` metres, distance to that line at the end of this substep.
            closing: ``[R]`` m/s, speed at which the robot approaches the line.
        """
        limits, dt, is_exact = self._limits, self._dt, self._motors.is_exact
        ups, downs = (
            np.where(turns, limits.corner_rates, rates) for rates in (limits.ups, limits.downs)
        )
        ahead = self._done + self._speeds * dt
        remaining = self._ends * self._size - ahead
        is_before, spare = remaining > 0, np.where(self._has_corner, limits.spare, 0.0)
        # Near a corner it brakes only as hard as it can while it turns, so it may always turn.
        is_at_corner = self._has_corner & (remaining < limits.corner)
        wanted = stopping_speeds(
            np.where(is_before, np.where(is_at_corner, remaining, remaining - spare), -remaining),
            np.where(is_at_corner, limits.corner_rates, downs),
            dt,
        )
        wanted = np.where(is_before, wanted, -wanted)
        fastest = self._motors.fastest(self._speeds, np.where(self._speeds < 0, downs, ups))
        speeds: Floats = np.minimum(wanted, fastest) if is_exact else wanted
        stopped = self._headings.turn(~self._are_free() | (self._backs != NOWHERE))
        if stopped.any():
            # Robots that do not drive exactly as commanded brake as hard as they can.
            slower = np.maximum(np.abs(self._speeds) - downs * dt, 0.0) if is_exact else 0.0
            speeds = np.where(stopped, np.sign(self._speeds) * slower, speeds)
        if is_exact:
            places = RoutePlaces(ahead, aside, closing, None)
        else:
            places = RoutePlaces(ahead, aside, self._closing, self._speeds)
        self._leaders.slow_down(speeds, places, downs)
        if not is_exact:
            speeds = np.minimum(speeds / self._motors.excess(self._speeds), fastest)
        return speeds

    def _choose_closing(self, aside: Floats, across: Floats) -> Floats:
        """Return the speeds at which robots are to approach the lines of their legs, ``[R]`` m/s.

        ``aside`` has their distances to the lines at the end of this substep in metres, ``[R]``, in
        the directions ``across``, ``[R, 2]``.
        """
        rates = self._limits.corner_rates
        now = -np.sign(aside) * _dots(self._velocities, across)
        speeds = stopping_speeds(np.abs(aside), rates, self._dt)
        if not self._motors.is_exact:  # a robot that is slower than commanded would never speed up
            return speeds
        return np.minimum(speeds, np.maximum(now, 0.0) + rates * self._dt)

    def _stop(self) -> None:
        """Stop the robots whose failures begin now, and let the others drive on."""
        if self._stops:
            now = self._substep * self._dt
            self._substep += 1
            self.stopped = self.failed.copy()
            for stop in self._stops:
                if stop.at <= now < stop.at + stop.seconds:
                    self.stopped[stop.robot] = True
                    if stop.seconds == math.inf and not self.failed[stop.robot]:
                        self.fail(stop.robot)

    def fail(self, robot: int) -> None:
        """Make a robot brake and stay for good, and change the routes of the others accordingly.

        A robot fails too if it could only go back into a cell that a failed robot reaches into. It
        is caught between robots and has no cell in which it could come to rest.
        """
        self.failed[robot] = self.stopped[robot] = True
        size, apart = self._size, self._leaders.apart
        nearest, farthest = self._rests()
        reached = self._committed()
        number = min(int(nearest[robot] // size), int(self._lasts[robot]))
        if number < self._lasts[robot]:
            number += bool(nearest[robot] - number * size >= apart + NEAR * size)
            is_between = farthest[robot] > (number + 1) * size - apart
            reached[robot] = min(number + is_between, int(self._lasts[robot]))
        closed = {self.routes.node(robot, each).cell for each in range(number, reached[robot] + 1)}
        changed = self.routes.cut(robot, number, reached.tolist(), self._present().tolist())
        for each, goes_back in changed.items():
            self._lasts[each] = last = self.routes.last(each)
            if goes_back:
                self._backs[each] = self._ends[each] = reached[each]
                self._has_corner[each] = False
            elif self._ends[each] >= last:
                self._ends[each], self._has_corner[each] = last, False
                self._backs[each] = NOWHERE
        self._lasts[robot] = number
        # The robot kept away from robots that rest, so it does not reach into their cells.
        rests = self._are_at_ends() & ~self.failed
        self.closed |= closed - {self.routes.end(each) for each in rests.nonzero()[0].tolist()}
        for each in range(len(self.stopped)):
            self._leaders.find_again(each, self._passed)
        if self._disturbances.slippery:
            self._expect_slips(range(len(self.stopped)))
        goes_back = self._backs != NOWHERE
        done = np.where(goes_back, 2 * self._backs * size - self._done, self._done)
        for each in range(len(self.stopped)):
            cells = {node.cell for _, node in self.routes.nodes(each, int(done[each] // size) + 1)}
            if not rests[each]:  # its end may be behind it, so that it comes back
                cells.add(self.routes.end(each))
            if not self.failed[each] and self.closed & cells:
                self.fail(each)

    def _present(self) -> Integers:
        """Return the first node of each route whose cell the robot has not left, ``[R]``."""
        last_left = np.floor((self._passed - self._leaders.apart) / self._size)
        present: Integers = last_left.astype(int) + 1
        return present

    def _committed(self) -> Integers:
        """Return the last node that each robot is at or cannot stop before, ``[R]``."""
        _, farthest = self._rests()
        last: Integers = np.minimum(np.ceil(farthest / self._size - NEAR), self._lasts)
        return last.astype(int)

    def _rests(self) -> tuple[Floats, Floats]:
        """Return the least and the greatest length driven after braking, ``[R]`` metres each."""
        limits = self._limits
        downs = np.where(self._turning(), limits.corner_rates, limits.downs)
        stops = (
            np.sign(self._speeds) * stopping_distances(np.abs(self._speeds), rates, self._dt)
            for rates in (limits.hardest, downs)
        )
        hardest, gentlest = (self._done + each for each in stops)
        return np.minimum(hardest, gentlest), np.maximum(hardest, gentlest)

    def _expect_slips(self, robots: Iterable[int]) -> None:
        """Find the robots that are on slippery floor or may be before they could stop."""
        slips = self._limits.slips.copy()
        reach = 2 + int(self._limits.normal_reach / self._size)
        for robot in robots:
            here = int(self._done[robot] // self._size)
            first = max(here - 1, self.routes.first(robot))  # including the cell that it is in
            numbers = range(first, self.routes.last(robot) + 1)
            cells = (self.routes.node(robot, number).cell for number in numbers)
            slips[robot] = any(map(self._disturbances.is_slippery, islice(cells, reach + 2)))
        self._limits.slip(slips)

    def _set_leg(self, robot: int, start: int) -> None:
        """Begin the leg of a robot that starts at a node of its route."""
        goes_back = bool(self._backs[robot] == start)
        self._starts[robot], self._ends[robot], self._backs[robot] = start, start + 1, NOWHERE
        self._along[robot] = along = np.array(self.routes.move(robot, start + 1)[::-1], float)
        self._origins[robot] = centre_of(self.routes.node(robot, start).cell, self._size)
        self._offsets[robot] = offset = self.positions[robot] - self._origins[robot]
        self._done[robot] = start * self._size + offset @ along
        self._speeds[robot] = speed = self._velocities[robot] @ along
        self._headings.face(robot, along, goes_back)
        self._motors.turn(robot, speed)
        self._leaders.turn(robot, start, self.routes.move(robot, start + 1))
        self._end_leg(robot)

    def _end_leg(self, robot: int) -> None:
        """Extend the leg of a robot to the node where its route turns or ends."""
        along, end = tuple(self._along[robot, ::-1].tolist()), int(self._ends[robot])
        turn = 0.0
        while end < self._lasts[robot]:
            move = self.routes.move(robot, end + 1)
            if move != along:
                turn = along[0] * move[1] - along[1] * move[0]
                break
            end += 1
        self._ends[robot] = end
        self._has_corner[robot] = turn != 0 and not self._headings.on_the_spot


def _dots(some: Floats, others: Floats) -> Floats:
    """Return the dot products of pairs of vectors, ``[R]``; a sum over two columns is slower."""
    return some[:, 0] * others[:, 0] + some[:, 1] * others[:, 1]
