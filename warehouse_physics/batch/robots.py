"""``B`` robots as arrays, which drive like a lone robot in ``robot.py`` on an even floor.

A robot drives, brakes and rests. After a hit that is in its way it brakes and drives back. Nothing
pushes a lone robot to the side, so it drives back in a straight line.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.tables import Flags, Integers, Rows
from warehouse_physics.arena import Hit, Position
from warehouse_physics.batch.warehouses import Warehouses
from warehouse_physics.energy import WorkBooks, kinetic, regained, spent, turn_work
from warehouse_physics.phases import AT_REST, BRAKE, GO, NEVER, REST
from warehouse_physics.profile import Floats, Substeps, brakings, lengths_of, plan_profiles
from warehouse_physics.robot import MAX_SECONDS
from warehouse_physics.spec import ARRIVED, RobotSpec


def turns_of(spec: RobotSpec) -> tuple[Substeps, Floats]:
    """Return the substeps of turns, and the work of the motors in J, ``[2, 4]`` each.

    Rows are without and with an item. Columns are the numbers of quarter turns to the right.
    """
    substeps, work = np.zeros((2, 4), np.int64), np.zeros((2, 4))
    for load, quarters in product((0, 1), (1, 2, 3)):
        shorter = min(quarters, 4 - quarters)
        substeps[load, quarters] = spec.turn_substeps(shorter, bool(load))
        if spec.is_differential:
            work[load, quarters] = turn_work(spec, shorter, bool(load))
    return substeps, work


class BatchRobots:
    """Drives the ``B`` robots of an arena, one action at a time.

    Attributes:
        gave_up: ``[B]`` bool, true if a wall was in the way.
        work: ``[B]`` joules, work of each motor in the action.
        substeps: ``[B]``, substeps until each robot was at rest.
    """

    def __init__(self, spec: RobotSpec, arena: Warehouses) -> None:
        self._spec, self.arena = spec, arena
        robots = len(arena.bodies)
        loads = (False, True)
        self._masses = np.array([spec.total_mass(load) for load in loads])
        self._drags = np.array([spec.drag_force(load) for load in loads])
        self._lead = spec.time_step / 2
        self._accelerations = np.array([spec.attainable_acceleration(load) for load in loads])
        self._decelerations = np.maximum(self._accelerations, spec.floor_deceleration)
        # The floor helps to brake. Where its drag exceeds the force needed, it brakes alone.
        self._going_forces = self._masses * self._accelerations
        self._braking_forces = np.maximum(self._going_forces, self._drags)
        self._turning, self._turn_work = turns_of(spec)
        self._headings = np.zeros(robots, np.intp)  # quarter turns from east
        self._loaded = np.zeros(robots, np.intp)
        self._force = np.zeros(robots)
        self._commands = np.zeros((robots, 2))
        self._phase = np.full(robots, REST)
        self._until: Substeps = np.full(robots, NEVER, np.int64)
        self._braking: Substeps = np.zeros(robots, np.int64)
        self._books = WorkBooks(robots)
        self.gave_up = np.zeros(robots, np.bool_)
        self.work = np.zeros(robots)
        self.substeps: Substeps = np.zeros(robots, np.int64)

    def place(self, row: int, position: Position) -> None:
        """Put a robot at rest at a position, facing east, for a new episode."""
        self.arena.place(row, position)
        self._headings[row] = 0

    def cells(self) -> NDArray[np.intp]:
        """Return the cells under the robots, ``[B, 2]`` with columns before rows."""
        self._look()
        return np.floor(self._positions / self._spec.cell_size).astype(np.intp)

    def drive(self, displacements: Floats, loaded: Flags) -> None:
        """Drive each robot to the middle of a cell, or back if a wall is in the way.

        ``displacements`` are in cells, ``[B, 2]`` with columns before rows.
        """
        self._load(loaded)
        self._home, self._displacements = self.cells(), displacements
        self._target = (self._home + displacements + 0.5) * self._spec.cell_size
        self._commands[:], self.gave_up[:], self.work[:] = 0.0, False, 0.0
        now = 0
        self._rest(slice(None), now)
        moving = np.flatnonzero(displacements.any(axis=1))
        turning = self._turn(moving)
        self._go(moving[turning == 0], now)
        self._brake(moving[turning > 0], now, turning[turning > 0])
        limit = MAX_SECONDS / self._spec.time_step
        while now < limit and (until := int(self._until.min())) < NEVER:
            self.arena.command(self._commands)
            now, hits = self.arena.stepper.run(now, until)
            self._look()
            if hits:
                self._meet(hits, now)
            self._next_phase(now)
        self.substeps[self._until < NEVER] = now

    def _turn(self, rows: Integers) -> Substeps:
        """Turn robots towards their displacements, and return the substeps of each on the spot."""
        right, down = self._displacements[rows].astype(np.intp).T
        headings = down % 4 + 2 * (right < 0)
        turns = self._loaded[rows], (headings - self._headings[rows]) % 4
        self._headings[rows] = headings
        self.work[rows] = self._turn_work[turns]
        turning: Substeps = self._turning[turns]
        return turning

    def _look(self) -> None:
        self._positions, self._velocities = self.arena.look()

    def _next_phase(self, now: int) -> None:
        """Start the phases that are due at substep ``now``, as in ``phases.py``.

        A lone robot meets no other robot, and has no time limit without disturbances.
        """
        due = np.flatnonzero(self._until <= now)
        is_going = self._phase[due] == GO
        gone, braked = due[is_going], due[~is_going]
        if len(gone):
            self._count_work(gone, self._velocities[gone], self._lead)
            self._brake(gone, now, self._braking[gone])
        if len(braked):
            self._count_braking(braked, self._velocities[braked], self._lead)
            speeds = lengths_of(self._velocities[braked])
            rolls = speeds > AT_REST
            if rolls.any():
                self._brake_from(braked[rolls], now, speeds[rolls])
                braked = braked[~rolls]
            off = lengths_of(self._target[braked] - self._positions[braked])
            arrived = off <= ARRIVED * self._spec.cell_size
            self._rest(braked[arrived], now)
            self._go(braked[~arrived], now)

    def _meet(self, hits: Sequence[Hit], now: int) -> None:
        """Make robots brake and drive back if a hit at substep ``now`` is in their way.

        A robot at rest has already ended its action, even while others still drive.
        """
        rows = np.array([hit.robot for hit in hits])
        pushes = np.array([hit.push for hit in hits])
        velocities = np.array([hit.velocity for hit in hits])
        is_going = self._phase[rows] == GO
        self._count_impact(rows[is_going], velocities[is_going])
        others = rows[~is_going]
        self._count_braking(others, velocities[~is_going], -self._lead)
        self._books.start(others, *self._readings(others, self._velocities[others], self._lead))
        along = (pushes * self._displacements[rows]).sum(axis=1)
        across = (pushes * self._displacements[rows][:, ::-1] * (1, -1)).sum(axis=1)
        is_hindered = (-along > abs(across)) & (self._phase[rows] != REST)
        rows = rows[is_hindered]
        self.gave_up[rows] = True
        self._target[rows] = (self._home[rows] + 0.5) * self._spec.cell_size
        self._brake_from(rows, now, lengths_of(self._velocities[rows]))

    def _go(self, rows: Integers, now: int) -> None:
        if not len(rows):
            return
        start = self._positions[rows]
        self._books.start(rows, start)
        acceleration = self._accelerations[self._loaded[rows]]
        displacements = self._target[rows] - start
        velocities, go, brake = plan_profiles(displacements, *self._spec.limits(acceleration))
        self._commands[rows] = velocities
        self._push(rows, self._going_forces)
        self._phase[rows], self._until[rows], self._braking[rows] = GO, now + go, brake

    def _brake_from(self, rows: Integers, now: int, speeds: Floats) -> None:
        decelerations = self._decelerations[self._loaded[rows]]
        self._brake(rows, now, brakings(speeds, decelerations, self._spec.time_step))

    def _brake(self, rows: Integers, now: int, substeps: Substeps) -> None:
        self._commands[rows] = 0.0
        self._push(rows, self._braking_forces)
        self._phase[rows] = BRAKE
        self._until[rows] = now + substeps

    def _load(self, loaded: Flags) -> None:
        for row in np.flatnonzero(loaded != self._loaded).tolist():
            self.arena.bodies[row].mass = self._masses[int(loaded[row])]
        self._loaded = loaded.astype(np.intp)

    def _push(self, rows: Integers, forces: Floats) -> None:
        """Limit the forces of the drives, where ``forces`` has the N without and with an item."""
        wanted = forces[self._loaded[rows]]
        changed = wanted != self._force[rows]
        if changed.any():
            self._force[rows] = wanted
            for row, force in zip(rows[changed].tolist(), wanted[changed].tolist(), strict=True):
                self.arena.drives[row].max_force = force

    def _count_work(self, rows: Integers, velocities: Floats, lead: float) -> None:
        """Add the work that the motors have done since the last count."""
        self.work[rows] += spent(self._work_since_count(rows, velocities, lead))

    def _count_braking(self, rows: Integers, velocities: Floats, lead: float) -> None:
        """Subtract the energy that the motors have recovered since the last count."""
        if self._spec.recuperation:
            self.work[rows] -= regained(self._spec, self._work_since_count(rows, velocities, lead))

    def _work_since_count(self, rows: Integers, velocities: Floats, lead: float) -> Floats:
        drags = self._drags[self._loaded[rows]]
        return self._books.count(rows, *self._readings(rows, velocities, lead), drags)

    def _readings(self, rows: Integers, velocities: Floats, lead: float) -> tuple[Floats, Floats]:
        """Return positions and kinetic energies; see ``Robot._reading``."""
        energies = kinetic(self._masses[self._loaded[rows]], *velocities.T)
        return self._positions[rows] + lead * velocities, energies

    def _count_impact(self, rows: Integers, before: Floats) -> None:
        """Add the work up to hits in this substep, and the work of the motors during the hits.

        The joint that drives a robot exerts the push of its motor minus the drag of the floor.
        """
        self._count_work(rows, before, -self._lead)
        after = self._velocities[rows]
        joints = np.array([self.arena.drives[row].impulse for row in rows.tolist()])
        pushes = joints + self._drags[self._loaded[rows]] * self._spec.time_step
        commands = self._commands[rows]
        forward = ((before + after) * commands).sum(axis=1) / lengths_of(commands)
        self.work[rows] += spent(pushes * forward / 2)
        self._books.start(rows, *self._readings(rows, after, self._lead))

    def _rest(self, rows: Rows, now: int) -> None:
        self._phase[rows], self._until[rows], self.substeps[rows] = REST, NEVER, now
