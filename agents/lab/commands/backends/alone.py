"""Robots that do not meet: deliveries of the same orders without traffic, as a bound.

Each robot drives on a floor of its own; the fleet sees all robots on one floor. Orders and turns at
chargers are assigned as with traffic, and every robot takes the quickest path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.fleet.scheduler import Scheduler
from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import FAR
from agents.mapf.memory import Memory
from warehouse_core import Cell, FleetEnv, Layout, Outcome
from warehouse_core.motion.base import BaseMotion, Ways
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tiles import WALL


class OwnFloors(BaseMotion):
    """Moves each robot as another motion does, on a floor of its own.

    The floors are below one another in one layout, with walls between them.

    Args:
        motion: motion whose robots drive through.
    """

    drives_through = True

    def __init__(self, motion: Any) -> None:
        self._motion, self.spec = motion, motion.spec
        self.cell_size, self.cell_steps = motion.cell_size, motion.cell_steps
        self.cell_joules = motion.cell_joules

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Put robots at rest; see ``Motion.reset``."""
        self._rows = layout.height + 1  # from a cell to the same one on the next floor
        floors = Layout([*layout.rows, WALL * layout.width] * len(cells))
        starts = [(row + self._rows * robot, col) for robot, (row, col) in enumerate(cells)]
        self._motion.reset(floors, starts, seed)

    def ways(self) -> Ways:
        """Return what each robot has ahead of it; see ``BaseMotion.ways``."""
        ways: Ways = self._motion.ways()
        ends = [self._on_one_floor(robot, end) for robot, end in enumerate(ways.ends)]
        return ways._replace(ends=ends, closed=())  # a robot that failed closes its own floor

    def fail(self, robot: int) -> None:
        """Let a robot stay where it is for good; see ``BaseMotion.fail``."""
        self._motion.fail(robot)

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Extend the ways and drive; see ``Motion.advance``."""
        outcomes = self._motion.advance(displacements, loaded)
        return [self._moved_up(robot, outcome) for robot, outcome in enumerate(outcomes)]

    def close(self) -> None:
        """Release the motion; see ``Motion.close``."""
        self._motion.close()

    def _on_one_floor(self, robot: int, cell: Cell) -> Cell:
        return cell[0] - self._rows * robot, cell[1]

    def _moved_up(self, robot: int, outcome: Outcome) -> Outcome:
        """Return what a robot did on its own floor as if it had been on the first."""
        path = outcome.path - (0.0, 0.0, self._rows * robot * self.cell_size, 0.0)
        return outcome._replace(cell=self._on_one_floor(robot, outcome.cell), path=path)


class AloneFleet:
    """Robots with orders, each of which goes as if it were alone on the floor.

    Args:
        assignment: a name of ``ASSIGNMENTS``.
    """

    dispatch = False

    def __init__(self, assignment: str) -> None:
        self._assignment = assignment
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self._scheduler: Scheduler | None = None

    def act(self, env: FleetEnv) -> NDArray[np.intp]:
        """Return the next action of each robot, as an index."""
        if self._scheduler is None:
            from agents.mapf.execution import corner_steps  # imports pymunk

            motion: Any = env.motion
            graph = Graph(env.layout, turn_cost=corner_steps(motion.spec))
            self._scheduler = Scheduler(env, self._assignment, graph)
            self._fields, self._memory = Fields(graph), Memory(graph, np.zeros(len(env.cells)))
        robots, goals, stays, actions = self._scheduler.duties(env)
        fields, here = self._fields, self._memory.places(robots.cells)
        rows, near = fields.rows(goals)[:, None], fields.near[here]
        is_open = near < fields.graph.places
        costs = fields.prices[here] + fields.matrix[rows, np.where(is_open, near, 0)]
        moves = np.where(is_open, costs, 2 * FAR).argmin(axis=1)
        return np.where(stays | (actions != WAIT), actions, moves)
