"""Counts of the steps of a fleet's robots, and the measures that follow from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.kernels import Kinds
from warehouse_core.motion.base import BatchOutcome
from warehouse_core.orders.order import Order
from warehouse_core.world.moves import ActionSet
from warehouse_core.world.tables import Flags, Integers

MOVED, WAITED, CHARGED, BY_WALL, BY_ROBOT, BY_PERSON, HANDLED, BUSY, ENDED, TURNED = range(10)
"""Kinds of a robot's steps. A robot that waits is busy while it still drives, picks or drops. A
robot that has ended does nothing."""

_KINDS = {"RIGHT": TURNED, "LEFT": TURNED, "WAIT": WAITED, "PICK": HANDLED, "DROP": HANDLED}
"""Kinds of the actions that are not moves, for robots that do not charge."""

SECONDS_PER_HOUR = 3600.0


@dataclass(frozen=True)
class FleetMeasures:
    """The performance of a fleet in an episode. Measures without any data are ``nan``.

    Attributes:
        steps: joint steps taken.
        seconds: simulated time. Each joint step lasts as long as its slowest robot needs.
        orders: number of orders released.
        delivered: number of items delivered.
        per_hour: throughput, the items delivered per hour of simulated time.
        mean_lateness: mean number of steps by which deliveries were late; 0 for those on time.
        worst_lateness: largest number of steps by which a delivery was late.
        on_time: share of deliveries that were not late, 0 to 1.
        joules: energy of all motions.
        joules_per_delivery: energy of all motions per delivered item.
        blocked_by_wall, blocked_by_robot, blocked_by_person: number of blocked moves by obstacle.
        waits: number of steps in which a robot waited at rest, but not on a charger.
        charging: number of steps in which a robot charged.
        distance: number of cells driven.
        stranded: number of robots with an empty battery or a failure.
        lost: number of orders that will never be delivered, because a robot counted in ``stranded``
            carries the item, is the only one that may take it, or blocks its pickup or dropoff.

    Example:
        >>> from warehouse_core import FleetEnv
        >>> env = FleetEnv(robots=2, starts=[(1, 1), (1, 2)])
        >>> observations, info = env.reset()
        >>> step = env.step(["N", "E"])
        >>> env.measures.distance, env.measures.blocked_by_wall
        (1, 1)
    """

    steps: int
    seconds: float
    orders: int
    delivered: int
    per_hour: float
    mean_lateness: float
    worst_lateness: float
    on_time: float
    joules: float
    joules_per_delivery: float
    blocked_by_wall: int
    blocked_by_robot: int
    blocked_by_person: int
    waits: int
    charging: int
    distance: int
    stranded: int = 0
    lost: int = 0


class Tally:
    """Counts of the steps of ``R`` robots on each of ``B`` floors.

    Attributes:
        for_kernels: kinds and sums for the kernels of fleets.
    """

    def __init__(self, floors: int, robots: int, people: int, actions: ActionSet) -> None:
        self._robots = robots
        # WALL and NOTHING are negative indices, which count from the end.
        self._kinds_by = np.array(
            [BY_ROBOT] * robots + [BY_PERSON] * people + [BY_WALL, MOVED], np.intp
        )
        self._kinds = np.array([_KINDS.get(word, MOVED) for word in actions.words])
        self._counts = np.zeros((floors * robots, TURNED + 1), np.int64)
        self._first_counts = np.arange(0, self._counts.size, TURNED + 1)
        self._joules = np.zeros(floors * robots)
        self._seconds = np.zeros(floors)
        self._deliveries = np.zeros(floors, np.int64)
        self.for_kernels = Kinds(
            self._kinds, self._kinds_by, WAITED, BUSY, CHARGED, ENDED,
            self._counts, self._joules, self._seconds, self._deliveries,
        )  # fmt: skip

    def clear(self, floors: Integers) -> None:
        """Reset the counts of some floors."""
        rows = (floors[:, None] * self._robots + np.arange(self._robots)).ravel()
        self._counts[rows], self._joules[rows] = 0, 0.0
        self._seconds[floors], self._deliveries[floors] = 0.0, 0

    def add(
        self,
        actions: Integers,
        outcome: BatchOutcome,
        charging: Flags | None,
        delivered: Integers,
        ended: Integers,
    ) -> None:
        """Count one step of all ``N`` robots.

        Args:
            actions: ``[N]`` actions of the robots.
            outcome: outcomes of the motion.
            charging: ``[N]`` flags of robots that charge; ``None`` on floors without chargers.
            delivered: rows of robots that deliver.
            ended: rows of robots that had ended before the step.
        """
        did = self._kinds.take(actions)
        if outcome.driving is not None:
            did[(did == WAITED) & outcome.driving] = BUSY
        if charging is not None:
            did[charging] = CHARGED
        blocked = outcome.blocked.nonzero()[0]
        if len(blocked):
            assert outcome.stopped_by is not None, "motions of fleets set it"
            did[blocked] = self._kinds_by[outcome.stopped_by[blocked]]
        did[ended] = ENDED
        self._counts.reshape(-1)[self._first_counts + did] += 1
        self._joules += outcome.joules
        for row in delivered.tolist():
            self._deliveries[row // self._robots] += 1
        self._seconds += np.maximum.reduce(outcome.seconds.reshape(-1, self._robots), axis=1)

    def counts(self, floor: int) -> NDArray[np.int64]:
        """Return ``[10, R]``, the steps of each kind for each robot on a floor; see ``MOVED``."""
        return self._counts[floor * self._robots : (floor + 1) * self._robots].T.copy()

    def measures(self, floor: int, steps: int, orders: Sequence[Order] | None) -> FleetMeasures:
        """Return the measures of a floor, except ``stranded`` and ``lost``.

        Args:
            floor: number of the floor.
            steps: joint steps taken.
            orders: all released orders; ``None`` for a fleet without orders.
        """
        done = self.counts(floor).sum(axis=1).tolist()
        seconds = float(self._seconds[floor])
        rows = slice(floor * self._robots, (floor + 1) * self._robots)
        joules, delivered = float(self._joules[rows].sum()), int(self._deliveries[floor])
        late = [
            max(order.delivered - order.due, 0)
            for order in orders or ()
            if order.delivered is not None
        ]
        return FleetMeasures(
            steps=steps,
            seconds=seconds,
            orders=len(orders or ()),
            delivered=delivered,
            per_hour=delivered / seconds * SECONDS_PER_HOUR if seconds else math.nan,
            mean_lateness=sum(late) / len(late) if late else math.nan,
            worst_lateness=float(max(late)) if late else math.nan,
            on_time=late.count(0) / len(late) if late else math.nan,
            joules=joules,
            joules_per_delivery=joules / delivered if delivered else math.nan,
            blocked_by_wall=done[BY_WALL],
            blocked_by_robot=done[BY_ROBOT],
            blocked_by_person=done[BY_PERSON],
            waits=done[WAITED],
            charging=done[CHARGED],
            distance=done[MOVED],
        )
