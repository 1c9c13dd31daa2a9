"""The log of a game of the League while it is played."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from agents.mapf.league.result import Result
from agents.mapf.league.tasks import TaskPool
from warehouse_core.world.robot_runners import League
from warehouse_core.world.tables import Integers


class Log:
    """What has happened so far.

    Args:
        starts: ``[R]``, cells in which the robots start.

    Attributes:
        late: number of steps that passed because a plan was late.
        errors: errors of joint actions: two robots, the step and words.
    """

    def __init__(self, starts: Integers) -> None:
        self._starts = starts
        self._actual: list[np.ndarray] = []
        self._planned: list[np.ndarray] = []
        self.late = 0
        self.errors: list[tuple[int, int, int, str]] = []

    @property
    def steps(self) -> int:
        """The number of steps so far."""
        return len(self._actual)

    def add(self, actual: Integers, planned: Integers) -> None:
        """Add a step: ``[R]`` actions, and those that were planned."""
        self._actual.append(actual.astype(np.uint8))
        self._planned.append(planned.astype(np.uint8))

    def result(
        self,
        problem: League,
        tasks: TaskPool,
        seconds: list[float],
        delays: Sequence[list[tuple[int, int]]] = (),
    ) -> Result:
        """Return the result of the game."""
        return Result(
            problem.year, problem.ticks, self._starts, np.array(self._actual),
            np.array(self._planned), tasks.finished, self.late, self.errors, seconds,
            [(task.revealed, task.cells) for task in tasks.tasks], tasks.errands, tasks.given,
            tasks.errors, list(delays),
        )  # fmt: skip
