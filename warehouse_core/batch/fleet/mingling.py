"""The motion of robots and people on the same floors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet.people import Crowd
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome, Outcome
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Flags, Integers


class MingledMotion(BaseBatchMotion):
    """Moves ``R`` robots among ``P`` people on each floor; see ``BatchMotion``.

    The motion that it is made of moves ``R + P`` bodies on each floor, the robots first. People
    enter before robots are placed.
    """

    def __init__(self, motion: BaseBatchMotion, robots: int, crowd: Crowd) -> None:
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
        ends = outcome.cells if outcome.ends is None else outcome.ends
        self._crowd.move(self._of_people(outcome.cells), self._of_people(ends))
        of_robots: list[Any] = [None if each is None else self._of_robots(each) for each in outcome]
        return BatchOutcome(*of_robots)

    def face(self, actions: Integers) -> None:
        """Let robots turn on the spot; see ``BaseBatchMotion.face``."""
        self._motion.face(self._joined(actions, np.full_like(self._crowd.cells, WAIT)))

    def fail(self, rows: Integers) -> None:
        """Let robots stay where they are for good; see ``BaseBatchMotion.fail``."""
        floors, robots = np.divmod(rows, self._robots)
        self._motion.fail(floors * self._bodies + robots)

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return what the robots of a floor, and then its people, did."""
        return self._motion.outcomes(floor)

    def close(self) -> None:
        """Close the motion of robots and people; see ``BatchMotion.close``."""
        self._motion.close()

    def _joined(self, robots: NDArray[Any], people: NDArray[Any]) -> NDArray[Any]:
        """Return the values of all bodies, from robots ``[F * R]`` and people ``[F, P]``."""
        return np.hstack([np.reshape(robots, (len(people), -1)), people]).ravel()

    def _of_people(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of the people ``[F, P]`` from the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, self._robots :]

    def _of_robots(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of the robots ``[N]`` from the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, : self._robots].ravel()
