"""Robots as arrays, with a step of the rules for all of them, and their observations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.floor import BatchFloor
from warehouse_core.batch.verdicts import NO_STATION, charging, judge_all, verdict_numbers
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome
from warehouse_core.task.encoding import FleetArrays, ObservationArrays
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import COUNTS_AS, EAST, FORWARD, HEADING_AFTER, TURN_ACTIONS
from warehouse_core.world.tables import Flags, Integers, Rows

Counts = NDArray[np.int32]


class RobotArrays:
    """``N`` robots that move together and are judged with the rules of ``task/rules.py``.

    Attributes:
        cells: ``[N]`` cells of the robots, numbered within their layouts.
        has_item: ``[N]`` flags of robots that hold an item.
    """

    def __init__(self, floor: BatchFloor, motion: BaseBatchMotion, count: int) -> None:
        self.floor, self.motion = floor, motion
        self.cells = np.zeros(count, np.intp)
        self.has_item = np.zeros(count, np.bool_)

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place some of the robots in their cells, without an item; see ``BatchMotion.place``."""
        self.motion.place(rows, cells, seeds)
        self.cells = self.cells.copy()  # see ``BatchFloor.stations``
        self.cells[rows] = cells
        self.has_item[rows] = False

    def step(
        self, actions: NDArray[np.intp]
    ) -> tuple[BatchOutcome, NDArray[np.float64], Flags, Flags | None]:
        """Carry out one action, 0 to 6, for each robot.

        Returns:
            The outcome of the motion, the rewards, flags of robots that have delivered their
            items, and flags of robots that charge. The last is ``None`` if no floor has a charger.
            The arrays belong to the caller.
        """
        outcome, judged = self.move(actions)
        return outcome, *self.judge(judged, outcome)

    def move(self, actions: NDArray[np.intp]) -> tuple[BatchOutcome, NDArray[np.intp]]:
        """Carry out the motion of one action for each robot.

        Returns:
            The outcome, and the index in ``ACTIONS`` as which each action counts.
        """
        outcome = self.motion.advance(actions, self.has_item)
        self.cells = outcome.cells
        return outcome, actions

    def judge(
        self, actions: Integers, outcome: BatchOutcome
    ) -> tuple[NDArray[np.float64], Flags, Flags | None]:
        """Apply the rules to each robot in its new cell; see ``move`` and ``step``."""
        on = self.floor.stations(self.cells)
        if outcome.driving is not None:
            on = np.where(outcome.driving, NO_STATION, on)
        verdicts = verdict_numbers(actions, on, self.has_item, outcome.blocked)
        rewards, self.has_item, delivered = judge_all(verdicts)
        charges = charging(verdicts) if self.floor.has_chargers else None
        return rewards, delivered, charges

    def masks(self) -> NDArray[np.int8]:
        """Return the masks ``[N, 7]`` int8: 1 for each action with an effect."""
        return self.floor.masks(self.cells, self.has_item)

    def observe(self, rows: Rows, battery: Counts, steps: Counts) -> ObservationArrays:
        """Return the observations of some robots, as new arrays.

        Args:
            rows: rows of the robots.
            battery: ``[N, 1]`` battery units left.
            steps: ``[N, 1]`` steps taken.
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


_IS_TURN = COUNTS_AS < WAIT
_IS_TURN[:, FORWARD] = False
_MOVES = np.where(_IS_TURN, WAIT, COUNTS_AS)
"""``[heading, action]``, index in ``ACTIONS`` of the move that the motion carries out."""

_TURNS = np.where(_IS_TURN, HEADING_AFTER, WAIT)
"""``[heading, action]``, direction to which the motion turns a robot; see ``face``."""


class HeadedRobots(RobotArrays):
    """``N`` robots with headings, whose actions are ``TURN_ACTIONS``.

    If the motion does not support turns, its robots wait instead.

    Attributes:
        headings: ``[N]`` headings, 0 to 3 for N, E, S and W.
    """

    def __init__(self, floor: BatchFloor, motion: BaseBatchMotion, count: int) -> None:
        super().__init__(floor, motion, count)
        self.headings = np.full(count, EAST)

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place some of the robots in their cells, heading east; see ``RobotArrays.place``."""
        super().place(rows, cells, seeds)
        self.headings[rows] = EAST

    def move(self, actions: NDArray[np.intp]) -> tuple[BatchOutcome, NDArray[np.intp]]:
        """Carry out the motion of one of ``TURN_ACTIONS`` for each robot."""
        entries = self.headings * len(TURN_ACTIONS) + actions
        self.motion.face(_TURNS.take(entries))
        self.headings = HEADING_AFTER.take(entries)
        return super().move(_MOVES.take(entries))[0], COUNTS_AS.take(entries)

    def masks(self) -> NDArray[np.int8]:
        """Return the masks ``[N, 6]`` int8: 1 for each action with an effect."""
        by_compass = super().masks()
        masks = np.ones((len(by_compass), len(TURN_ACTIONS)), np.int8)
        masks[:, FORWARD] = by_compass[np.arange(len(masks)), self.headings]
        masks[:, TURN_ACTIONS.index("WAIT") :] = by_compass[:, WAIT:]
        return masks

    def observe(self, rows: Rows, battery: Counts, steps: Counts) -> FleetArrays:
        """Return observations including headings; see ``RobotArrays.observe``."""
        observed = cast(FleetArrays, super().observe(rows, battery, steps))
        observed["heading"] = self.headings[rows].astype(np.int64)
        return observed
