"""Robots with headings as arrays: they drive forward and turn on the spot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.shell.floor import Floor
from warehouse_core.batch.shell.robots import Counts, Robots
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome
from warehouse_core.task.encoding import FleetArrays
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import COUNTS_AS, EAST, FORWARD, HEADING_AFTER, TURN_ACTIONS
from warehouse_core.world.tables import Flags, Integers, Rows

_IS_TURN = COUNTS_AS < WAIT
_IS_TURN[:, FORWARD] = False
_MOVES = np.where(_IS_TURN, WAIT, COUNTS_AS)
"""Index in ``ACTIONS`` of what the motion carries out, by heading and action."""

_TURNS = np.where(_IS_TURN, HEADING_AFTER, WAIT)
"""Direction that the motion turns a robot to, by heading and action; see ``face``."""


class HeadedRobots(Robots):
    """``N`` robots with headings; their actions are ``TURN_ACTIONS``.

    A motion whose robots cannot turn waits in place of a turn.

    Attributes:
        headings: ``[N]``, 0 to 3 for N, E, S and W.
    """

    def __init__(self, floor: Floor, motion: BaseBatchMotion, count: int) -> None:
        super().__init__(floor, motion, count)
        self.headings = np.full(count, EAST)

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put some of the robots in their cells, heading east; see ``Robots.place``."""
        super().place(rows, cells, seeds)
        self.headings[rows] = EAST

    def step(
        self, actions: Integers
    ) -> tuple[BatchOutcome, NDArray[np.float64], Flags, Flags | None]:
        """Carry out one of ``TURN_ACTIONS`` for each robot; see ``Robots.step``."""
        entries = self.headings * len(TURN_ACTIONS) + actions
        self.motion.face(_TURNS.take(entries))
        self.headings = HEADING_AFTER.take(entries)
        return self._carry_out(_MOVES.take(entries), COUNTS_AS.take(entries))

    def masks(self) -> NDArray[np.int8]:
        """Return ``[N, 6]`` int8: 1 for each action that does something now."""
        by_compass = super().masks()
        masks = np.ones((len(by_compass), len(TURN_ACTIONS)), np.int8)
        masks[:, FORWARD] = by_compass[np.arange(len(masks)), self.headings]
        masks[:, TURN_ACTIONS.index("WAIT") :] = by_compass[:, WAIT:]
        return masks

    def observe(self, rows: Rows, battery: Counts, steps: Counts) -> FleetArrays:
        """Return what some of the robots observe, with their headings; see ``Robots.observe``."""
        observed = cast(FleetArrays, super().observe(rows, battery, steps))
        observed["heading"] = self.headings[rows].astype(np.int64)
        return observed
