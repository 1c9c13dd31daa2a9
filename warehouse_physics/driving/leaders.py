"""The robots that others have to wait for, or may follow, on their ways.

A robot may come to the middle of a cell when its *leader* there, the robot that is in that cell
before it, is so far beyond the middle that the two are apart. Until then it stops in the cell
before, or follows its leader at a distance that is measured along the way through the shared cell.
Round a corner, two robots with ``d`` between them along the way are ``sqrt(1 / 2) * d`` apart. For
robots with a radius of up to 0.35 of a cell, a distance of just less than a cell is enough there,
which lets all robots of a queue or of a ring move at the same time.
"""

from __future__ import annotations

import math

import numpy as np

from warehouse_physics.driving.dependencies import Dependencies
from warehouse_physics.driving.limits import Limits
from warehouse_physics.profile import Floats, stopping_distances, stopping_speeds
from warehouse_physics.spec import RobotSpec

NOWHERE = 2**40
"""Number in place of a node where a robot has to wait: so far away that nobody gets there."""

CLEARANCE = 0.01
"""Share of a cell that is left between robots that follow each other straight on."""

MAX_LEADERS = 50
"""Most leaders of a robot. Only robots that can hardly brake, on ice, would look for more."""

MAX_ROUNDS = 100
"""Most rounds in which robots that follow each other in a chain agree on speeds; few are needed."""


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


class Leaders:
    """The next cells on the ways of ``R`` robots where they have leaders, ``[R, K]`` of them.

    Attributes:
        nodes: ``[R, K]`` numbers of these cells on the way, or ``NOWHERE``.
        apart: metres beyond the middle of a cell where a robot has left it.
    """

    def __init__(self, spec: RobotSpec, ways: Dependencies, limits: Limits) -> None:
        self._size, self._dt = spec.cell_size, spec.time_step
        self._ways, self._limits = ways, limits
        self.apart = 2 * spec.radius + CLEARANCE * spec.cell_size
        self._apart_at_corners = corner_distance(spec)
        self._most = min(1 + math.ceil(limits.reach / self._size), MAX_LEADERS)
        shape = len(limits.loaded), self._most
        self.nodes = np.full(shape, NOWHERE)
        self._looked = [0] * shape[0]  # up to which nodes of the ways
        self._leaders = np.zeros(shape, np.intp)
        self._leaving = np.zeros(shape, np.int64)
        self._gaps = np.zeros(shape)

    def find(self, robot: int, done: Floats) -> None:
        """Find the next cells of a robot where it has leaders, as far as there is space for them.

        Here and below ``done`` is the length of way that each robot has done, ``[R]`` metres.
        """
        slot, last = np.count_nonzero(self.nodes[robot] != NOWHERE), self._ways.last(robot)
        number = self._looked[robot]
        while number < last and slot < self._most:
            number += 1
            for leader, leaving in self._ways.node(robot, number).after:
                if self._has_left(done, leader, leaving):
                    continue
                if slot == self.nodes.shape[1]:
                    self._widen()
                is_straight = leaving < self._ways.last(leader) and (
                    self._ways.move(leader, leaving + 1) == self._ways.move(robot, number)
                )
                self.nodes[robot, slot] = number
                self._leaders[robot, slot], self._leaving[robot, slot] = leader, leaving
                self._gaps[robot, slot] = self.apart if is_straight else self._apart_at_corners
                slot += 1
        self._looked[robot] = number

    def find_anew(self, robot: int, done: Floats) -> None:
        """Find the next cells of a robot where it has leaders after its way has changed."""
        self.nodes[robot] = NOWHERE
        self._looked[robot] = max(self._ways.first(robot), int(done[robot] // self._size) - 1)
        self.find(robot, done)

    def drop(self, done: Floats) -> None:
        """Forget the leaders that have moved on, and find the next ones."""
        passed = done[self._leaders] - self._leaving * self._size
        is_gone = (self.nodes != NOWHERE) & (passed >= self.apart)
        rows = is_gone.any(axis=1).nonzero()[0]
        if not len(rows):
            return
        kept = np.argsort(is_gone[rows], axis=1, kind="stable")
        self.nodes[is_gone] = NOWHERE
        for values in (self.nodes, self._leaders, self._leaving, self._gaps):
            values[rows] = np.take_along_axis(values[rows], kept, axis=1)
        for robot in rows.tolist():
            self.find(robot, done)

    def slow_down(
        self, speeds: Floats, ahead: Floats, downs: Floats, now: Floats | None = None
    ) -> None:
        """Lower the speeds of robots, ``[R]`` in place, so that none comes too close to a leader.

        Args:
            speeds: ``[R]`` m/s, speeds that they would have without leaders.
            ahead: ``[R]`` metres, length of way that each robot has done when it gets its speed.
            downs: ``[R]`` m/s², rate at which each can brake.
            now: ``[R]`` m/s, present speeds, where it is not known which speeds robots get. Leaders
                may then brake as hard as they can.
        """
        to_nodes = self.nodes * self._size - ahead[:, None]
        before = stopping_speeds(to_nodes - self._size, downs[:, None], self._dt)
        # Robots that can still stop before all cells with leaders need not look at the leaders.
        rows = np.flatnonzero((before < speeds[:, None]).any(axis=1))
        if not len(rows):
            return
        leaders, dt, rates, before = self._leaders[rows], self._dt, downs[rows, None], before[rows]
        passed = ahead[leaders] - self._leaving[rows] * self._size
        gaps = to_nodes[rows] + passed - self._gaps[rows]
        hardest = self._limits.hardest
        if now is not None:
            now = np.where(now > 0, np.maximum(now - hardest * dt, 0.0), now)
        for _ in range(MAX_ROUNDS):
            theirs = (speeds if now is None else now)[leaders]
            stops = stopping_distances(np.abs(theirs), hardest[leaders], dt)
            room = gaps + np.sign(theirs) * stops
            following = np.minimum(stopping_speeds(room, rates, dt), gaps / dt + theirs)
            slower = np.minimum(speeds[rows], np.maximum(before, following).min(axis=1))
            if np.array_equal(slower, speeds[rows]):
                break
            speeds[rows] = slower

    def _widen(self) -> None:
        """Add a column, as a robot has several leaders in one cell."""
        by_one = (0, 0), (0, 1)
        self.nodes = np.pad(self.nodes, by_one, constant_values=NOWHERE)
        self._leaders, self._leaving = (
            np.pad(each, by_one) for each in (self._leaders, self._leaving)
        )
        self._gaps = np.pad(self._gaps, by_one)

    def _has_left(self, done: Floats, leader: int, number: int) -> bool:
        return bool(done[leader] - number * self._size >= self.apart)
