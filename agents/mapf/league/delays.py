"""Delays of robots, as problems of 2026 say how they are drawn.

Delays have the League's distributions and NumPy's random numbers, so that a seed gives other delays
than in the Start-Kit. ``R`` is the number of robots.

Source: ``src/DelayGenerator.cpp`` of the League's Start-Kit, 3.1.0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.robot_runners import Delays
from warehouse_core.world.tables import Integers


class DelayDraw:
    """Draws the delays of robots, tick by tick.

    Args:
        delays: distribution, or ``None`` for no delays.
        robots: ``R``.

    Attributes:
        intervals: ``[R]`` lists of pairs: the first tick of a delay, and the tick after its last.
    """

    def __init__(self, delays: Delays | None, robots: int) -> None:
        self._delays, self._tick = delays, 0
        self._rng = np.random.default_rng(delays.seed if delays else 0)
        self._until: Integers = np.zeros(robots, np.int64)
        self.intervals: list[list[tuple[int, int]]] = [[] for _ in range(robots)]

    def next_tick(self) -> NDArray[np.bool_]:
        """Return which robots are delayed in the next tick, ``[R]``."""
        tick, self._tick = self._tick, self._tick + 1
        if self._delays is not None:
            robots = self._chosen(self._delays, np.flatnonzero(self._until <= tick))
            self._until[robots] = tick + self._lengths(self._delays, len(robots))
            for robot in robots.tolist():
                self.intervals[robot].append((tick, int(self._until[robot])))
        return self._until > tick

    def _chosen(self, delays: Delays, free: Integers) -> Integers:
        """Return the robots whose delay begins, some of the free ones."""
        if delays.event == "bernoulli":
            return free[self._rng.random(len(free)) < delays.probability]
        count = self._rng.poisson(len(self._until) * delays.probability)
        return self._rng.permutation(free)[:count]

    def _lengths(self, delays: Delays, count: int) -> Integers:
        """Return the ticks of so many delays."""
        span = delays.longest - delays.shortest
        if delays.duration == "uniform":
            return self._rng.integers(delays.shortest, delays.longest + 1, count)
        mean = delays.shortest + span * delays.mean
        lengths = np.rint(self._rng.normal(mean, span * delays.deviation, count))
        return np.clip(lengths, delays.shortest, delays.longest).astype(np.int64)
