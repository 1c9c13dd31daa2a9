"""The robots that others have to wait for or may follow, and the speeds at which they do.

The *leader* of a robot in a cell is the robot that passes the cell before it. A robot may come to
the middle of the cell when its leader there is so far beyond the middle that the two do not touch.
Until then it stops in the cell before, or follows its leader. The distance to the leader is
measured along the routes of both robots through the shared cell.

This distance equals the sum of the distances in rows and columns, even where robots cut corners. If
it is ``d`` along a route that turns, the two robots are at least ``sqrt(1 / 2) * d`` apart. For
robots with a radius of up to 0.35 of a cell, slightly less than one cell is therefore enough. This
lets all robots of a queue or a ring move at the same time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warehouse_core import Cell
from warehouse_core.world.tables import Flags, Integers
from warehouse_physics.driving.dependencies import Dependencies
from warehouse_physics.driving.limits import CORNER, Limits
from warehouse_physics.profile import Floats, stopping_distances, stopping_speeds
from warehouse_physics.spec import RobotSpec

NOWHERE = 2**40
"""Number that stands for no node. It is so large that no robot gets there."""

CLEARANCE = 0.01
"""Gap between robots that follow each other straight on, as a share of a cell."""

MAX_LEADERS = 50
"""Largest number of leaders of a robot. Only robots that hardly brake, on ice, look for more."""

MAX_ROUNDS = 100
"""Largest number of rounds in which the robots of a chain adapt their speeds to each other. Few are
needed."""


BEFORE, BEYOND = 0.5, 0.3
"""Shares of a cell. A leader may begin to turn when it is ``BEFORE`` short of the middle of a cell.
Once it is ``BEYOND`` the middle, its followers must keep the distance for corners."""


def corner_distance(spec: RobotSpec) -> float:
    """Return the distance in metres at which robots follow each other round corners.

    Raises:
        ValueError: the radius is too large for a distance of less than a cell.
    """
    needed = math.sqrt(2) * 2 * spec.radius
    if needed >= spec.cell_size:
        raise ValueError(
            f"radius is {spec.radius!r}; with cell_size {spec.cell_size!r} robots that drive "
            f"through need a radius below {spec.cell_size / math.sqrt(8)!r}"
        )
    return (needed + spec.cell_size) / 2


def straight_distance(spec: RobotSpec) -> float:
    """Return the distance in metres at which robots follow each other straight on.

    The robot in front may cut its next corner, unless it turns on the spot. It is then closer than
    the distance along its route.
    """
    needed = 2 * spec.radius / spec.cell_size + CLEARANCE
    if spec.turns_on_the_spot:
        return spec.cell_size * needed
    beyond = max(needed - (1 - CORNER), 0.0) / CORNER
    # Let c be CORNER. A robot that has driven 1 - c + u cells along its route is then
    # 1 - c + u - u * u / (4 * c) cells away from where it set off.
    return spec.cell_size * (needed + CORNER * (2 * (1 - math.sqrt(1 - beyond)) - beyond))


class RoutePlaces(NamedTuple):
    """The places of ``R`` robots on their routes, ``[R]`` each.

    Attributes:
        done: metres of its route that a robot has driven, measured along its leg.
        aside: metres from the robot to the line of its leg.
        closing: m/s at which it approaches that line.
        speeds: m/s, present speeds, if the next speeds are uncertain. It is then assumed that
            leaders may brake as hard as they can. ``None`` if robots drive exactly as commanded.
    """

    done: Floats
    aside: Floats
    closing: Floats
    speeds: Floats | None


class Leaders:
    """The next cells on the routes of ``R`` robots in which they have leaders, at most ``K`` each.

    In the methods, ``passed`` is the length of the route that each robot has left behind, ``[R]``
    in metres. It is less than the length driven while the robot is off the line of its leg.

    Attributes:
        nodes: ``[R, K]``, numbers of these cells in the route, or ``NOWHERE``.
        apart: metres beyond the middle of a cell at which a robot has left it.
    """

    def __init__(self, spec: RobotSpec, routes: Dependencies, limits: Limits) -> None:
        self._size, self._dt = spec.cell_size, spec.time_step
        self._routes, self._limits = routes, limits
        self._on_the_spot = spec.turns_on_the_spot
        self.apart = straight_distance(spec)
        self._apart_at_corners = corner_distance(spec)
        self._most = min(1 + math.ceil(limits.reach / self._size), MAX_LEADERS)
        shape = len(limits.loaded), self._most
        self.nodes = np.full(shape, NOWHERE)
        self._looked = [0] * shape[0]  # last node of each route at which leaders were looked for
        self._leaders = np.zeros(shape, np.intp)
        self._leaving = np.zeros(shape, np.int64)
        # Distances to keep to leaders, before and beyond the middle of the cell.
        self._nearest, self._farthest = np.zeros((2, *shape))

    def find(self, robot: int, passed: Floats) -> None:
        """Find the next cells in which a robot has leaders, as far as there is space for them."""
        slot, last = int((self.nodes[robot] != NOWHERE).sum()), self._routes.last(robot)
        number = self._looked[robot]
        while number < last and slot < self._most:
            number += 1
            for leader, leaving in self._routes.node(robot, number).after:
                if self._has_left(passed, leader, leaving):
                    continue
                if slot == self.nodes.shape[1]:
                    self._widen()
                self.nodes[robot, slot] = number
                self._leaders[robot, slot], self._leaving[robot, slot] = leader, leaving
                self._keep_apart(robot, slot, self._routes.move(robot, number))
                slot += 1
        self._looked[robot] = number

    def find_again(self, robot: int, passed: Floats) -> None:
        """Find the next cells in which a robot has leaders, after its route has changed."""
        self.nodes[robot] = NOWHERE
        self._looked[robot] = max(self._routes.first(robot), int(passed[robot] // self._size) - 1)
        self.find(robot, passed)

    def turn(self, robot: int, node: int, move: Cell) -> None:
        """Update the distances to the leaders in a cell from which a robot turns by ``move``."""
        for slot in (self.nodes[robot] == node).nonzero()[0].tolist():
            self._keep_apart(robot, slot, move)

    def drop(self, passed: Floats) -> None:
        """Forget the leaders that have moved on, and find the next ones."""
        beyond = passed[self._leaders] - self._leaving * self._size
        is_gone = (self.nodes != NOWHERE) & (beyond >= self.apart)
        rows = is_gone.any(axis=1).nonzero()[0]
        if not len(rows):
            return
        kept = np.argsort(is_gone[rows], axis=1, kind="stable")
        self.nodes[is_gone] = NOWHERE
        for values in (self.nodes, self._leaders, self._leaving, self._nearest, self._farthest):
            values[rows] = np.take_along_axis(values[rows], kept, axis=1)
        for robot in rows.tolist():
            self.find(robot, passed)

    def leave(self, ends: Integers, passed: Floats, speeds: Floats) -> Flags:
        """Return whether each robot's node in ``ends`` will be free of its leaders, ``[R]``.

        The leaders drive along their routes at ``speeds``, ``[R]`` m/s, and may brake as hard as
        they can.
        """
        beyond = (passed + self._stops(speeds))[self._leaders] - self._leaving * self._size
        is_free = (self.nodes > ends[:, None]) | (beyond >= self.apart)
        return np.asarray(is_free.all(axis=1))

    def slow_down(self, speeds: Floats, places: RoutePlaces, downs: Floats) -> None:
        """Lower ``speeds`` in place, so that no robot comes too close to a leader.

        Args:
            speeds: ``[R]`` m/s, speeds that the robots would have without leaders.
            places: places of the robots when they get these speeds.
            downs: ``[R]`` m/s², rate at which each robot can brake.
        """
        to_nodes = self.nodes * self._size - places.done[:, None]
        before = stopping_speeds(to_nodes - self._size, downs[:, None], self._dt)
        # Robots that can still stop before all cells with leaders need not consider the leaders.
        rows = np.flatnonzero((before < speeds[:, None]).any(axis=1))
        if not len(rows):
            return
        leaders, dt, rates, before = self._leaders[rows], self._dt, downs[rows, None], before[rows]
        to_nodes = to_nodes[rows]
        passed = (places.done - places.aside)[leaders] - self._leaving[rows] * self._size
        across = to_nodes + places.aside[rows, None] - self._apart_at_corners
        closing, now = places.closing, places.speeds
        if now is not None:
            now = np.where(now > 0, np.maximum(now - self._limits.hardest * dt, 0.0), now)
        own_aside = closing[rows, None]
        for _ in range(MAX_ROUNDS):
            along = speeds if now is None else now
            # A leader that turns approaches its line, but perhaps more slowly than it brakes.
            stops = np.minimum(
                self._stops(along) + places.aside, self._stops(along + places.closing)
            )
            rests = self._beyond(rows, passed + stops[leaders])
            soon = passed + (along + closing)[leaders] * dt
            following = np.minimum(
                stopping_speeds(to_nodes + rests, rates, dt),
                np.maximum(
                    (to_nodes + self._beyond(rows, soon)) / dt, (across + soon) / dt - own_aside
                ),
            )
            slower = np.minimum(speeds[rows], np.maximum(before, following).min(axis=1))
            if np.array_equal(slower, speeds[rows]):
                break
            speeds[rows] = slower

    def _stops(self, speeds: Floats) -> Floats:
        """Return the distances ``[R]`` in metres in which robots stop with all their force.

        ``speeds`` are their present speeds in m/s, ``[R]``.
        """
        distances: Floats = np.sign(speeds) * stopping_distances(
            np.abs(speeds), self._limits.hardest, self._dt
        )
        return distances

    def _beyond(self, rows: Integers, passed: Floats) -> Floats:
        """Return how far beyond the middle of each cell robots may come, ``[N, K]`` metres.

        Their leaders are ``passed`` metres beyond the middle, ``[N, K]``.
        """
        nearest, farthest = self._nearest[rows], self._farthest[rows]
        share = (passed / self._size + BEFORE) / (BEFORE + BEYOND)
        beyond: Floats = passed - nearest - (farthest - nearest) * np.clip(share, 0.0, 1.0)
        return beyond

    def _keep_apart(self, robot: int, slot: int, move: Cell) -> None:
        """Set the distances to a leader, for a robot that drives in the direction ``move``."""
        leader, leaving = int(self._leaders[robot, slot]), int(self._leaving[robot, slot])
        routes, first = self._routes, self._routes.first(leader)
        goes_on = leaving < routes.last(leader) and routes.move(leader, leaving + 1) == move
        came_along = first < leaving and routes.move(leader, leaving) == move
        # A leader that turns on the spot stops first, so it must not be followed closely.
        came_along &= not self._on_the_spot
        straight, corner = self.apart, self._apart_at_corners
        self._nearest[robot, slot] = straight if goes_on or came_along else corner
        self._farthest[robot, slot] = straight if goes_on else corner

    def _widen(self) -> None:
        """Add a column, because a robot has several leaders in one cell."""
        by_one = (0, 0), (0, 1)
        self.nodes = np.pad(self.nodes, by_one, constant_values=NOWHERE)
        self._leaders, self._leaving = (
            np.pad(each, by_one) for each in (self._leaders, self._leaving)
        )
        self._nearest, self._farthest = (
            np.pad(each, by_one) for each in (self._nearest, self._farthest)
        )

    def _has_left(self, passed: Floats, leader: int, number: int) -> bool:
        return bool(passed[leader] - number * self._size >= self.apart)
