"""Robots as arrays: one step of the rules for all of them, and what they observe."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.shell.floor import Floor
from warehouse_core.batch.shell.verdicts import NO_STATION, charging, judge_all, verdict_numbers
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.world.tables import Flags, Integers, Rows

Counts = NDArray[np.int32]


class Robots:
    """``N`` robots, moved together and judged by the rules of ``task/rules.py``.

    Attributes:
        cells: ``[N]``, numbered within their layouts.
        has_item: ``[N]`` bool.
    """

    def __init__(self, floor: Floor, motion: BaseBatchMotion, count: int) -> None:
        self.floor, self.motion = floor, motion
        self.cells = np.zeros(count, np.intp)
        self.has_item = np.zeros(count, np.bool_)

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put some of the robots in their cells, without an item; see ``BatchMotion.place``."""
        self.motion.place(rows, cells, seeds)
        self.cells = self.cells.copy()  # see ``Floor.stations``
        self.cells[rows] = cells
        self.has_item[rows] = False

    def step(
        self, actions: Integers
    ) -> tuple[BatchOutcome, NDArray[np.float64], Flags, Flags | None]:
        """Carry out one action, 0 to 6, for each robot.

        Returns:
            The outcome of the motion, the rewards, whether each robot has delivered its item, and
            whether it charges, ``None`` if no floor has a charger. The arrays belong to the caller.
        """
        return self._carry_out(actions, actions)

    def _carry_out(
        self, moves: Integers, actions: Integers
    ) -> tuple[BatchOutcome, NDArray[np.float64], Flags, Flags | None]:
        """Let the motion carry out ``moves``, and judge the robots by ``actions``; see ``step``."""
        outcome = self.motion.advance(moves, self.has_item)
        self.cells = outcome.cells
        on = self.floor.stations(self.cells)
        if outcome.driving is not None:
            on = np.where(outcome.driving, NO_STATION, on)
        verdicts = verdict_numbers(actions, on, self.has_item, outcome.blocked)
        rewards, self.has_item, delivered = judge_all(verdicts)
        charges = charging(verdicts) if self.floor.has_chargers else None
        return outcome, rewards, delivered, charges

    def masks(self) -> NDArray[np.int8]:
        """Return ``[N, 7]`` int8: 1 for each action that does something now."""
        return self.floor.masks(self.cells, self.has_item)

    def observe(self, rows: Rows, battery: Counts, steps: Counts) -> ObservationArrays:
        """Return fresh arrays of what some of the robots observe.

        ``battery`` and ``steps``, ``[N, 1]``, are the units that they have left and steps taken.
        """
        floor, cells, has_item = self.floor, self.cells[rows], self.has_item[rows]
        places = floor.places(rows, cells)
        pickups, dropoffs = floor.station_places[:, rows]
        return {
            "local_grid": floor.windows(rows, cells, has_item),
            "robot_pos": places,
            "has_item": has_item.astype(np.int64),
            "battery": battery,
            "steps": steps,
            "pickup_pos": pickups.copy(),
            "dropoff_pos": dropoffs.copy(),
        }
