"""The motion of a fleet: its robots, and the people among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warehouse_core.fleet.people import Crowd
from warehouse_core.motion.base import Outcome
from warehouse_core.motion.vector import BatchMotion, BatchOutcome, Flags, Integers


class FleetMotion:
    """A ``BatchMotion`` of ``R`` robots on each floor, among ``P`` people.

    Args:
        motion: moves ``R + P`` bodies on each floor, the robots first.
        robots: ``R``.
        crowd: the people, who have entered before the robots are placed.
    """

    def __init__(self, motion: BatchMotion, robots: int, crowd: Crowd) -> None:
        self._motion, self._robots, self._crowd = motion, robots, crowd
        self._bodies = robots + crowd.cells.shape[1]

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put robots and people of some floors in their cells; see ``BatchMotion.place``."""
        floors = rows[:: self._robots] // self._robots
        bodies = floors[:, None] * self._bodies + np.arange(self._bodies)
        people = self._crowd.cells[floors]
        self._motion.place(bodies.ravel(), self._joined(cells, people), seeds)

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot and person; see ``BatchMotion.advance``."""
        people = self._crowd.actions()
        outcome = self._motion.advance(
            self._joined(actions, people), self._joined(loaded, np.zeros_like(people, np.bool_))
        )
        values = [np.reshape(each, (-1, self._bodies)) for each in outcome]
        self._crowd.cells = values[0][:, self._robots :]
        return BatchOutcome(*(np.ravel(each[:, : self._robots]) for each in values))

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return what the robots of a floor, and then its people, did; see ``BatchMotion``."""
        return self._motion.outcomes(floor)

    def close(self) -> None:
        """Close the motion of robots and people; see ``BatchMotion.close``."""
        self._motion.close()

    def _joined(self, robots: NDArray, people: NDArray) -> NDArray:
        """Return values of robots ``[F * R]`` and people ``[F, P]`` as those of all bodies."""
        return np.hstack([np.reshape(robots, (len(people), -1)), people]).ravel()
