"""Which robots of a crowd are led to their goals at a time, while the others give way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Graph
from agents.mapf.kernels.floor import FAR, NONE
from agents.mapf.planner import Situation
from warehouse_core.world.tables import Integers

REGION, REGION_LED = 8, 0.44
"""Cells across a region, and most robots for each of its open cells that are led into it.

Where more robots want to get in than come out, a jam grows that takes up ever more of those that
are led.
"""

STALL, REST = 60, 60
"""Steps after which a robot that has come no nearer to its goal rests, and how many it rests in the
mean. Robots that want to get out come past those that want to get in so.
"""


class Leading:
    """The robots that are led, of ``R`` robots.

    Args:
        graph: floor.
        robots: ``R``.
        most: most robots that are led at a time.
        seed: seed of the times for which robots rest.
    """

    def __init__(self, graph: Graph, robots: int, most: int, seed: int | None) -> None:
        self._most, self._draws = most, np.random.default_rng(seed)
        self._wanted, self._is_led = np.full(robots, NONE), np.zeros(robots, np.bool_)
        self._least, self._stalled, self._rest = np.zeros((3, robots), np.int64)
        self._regions, self._room = regions_of(graph)

    def goals(self, situation: Situation, distances: Integers) -> Integers:
        """Return the goals of the robots that are led now, and the cells of the others, ``[R]``.

        Whoever is led is led until it is at its goal, has another one, or stalls. Then the robot
        that is nearest to its goal takes its place, if there is room in the region of the goal,
        where robots that rest keep theirs. Who has no way to its goal is not led.
        """
        self._watch(situation, distances)
        self._choose(situation, distances)
        return np.where(self._is_led, situation.goals, situation.cells)

    def _watch(self, situation: Situation, distances: Integers) -> None:
        """Let robots rest that have stalled."""
        is_new = situation.goals != self._wanted
        self._wanted = situation.goals.copy()
        self._is_led &= ~is_new & (situation.goals != situation.cells) & (distances < FAR)
        is_nearer = ~self._is_led | (distances < self._least)
        self._least = np.where(is_nearer, distances, self._least)
        self._stalled = np.where(is_nearer, 0, self._stalled + 1)
        stalled = np.flatnonzero(self._stalled >= STALL)
        self._is_led[stalled] = False
        self._rest = np.where(is_new, 0, np.maximum(self._rest - 1, 0))
        self._rest[stalled] = self._draws.integers(REST // 2, 3 * REST // 2, len(stalled))

    def _choose(self, situation: Situation, distances: Integers) -> None:
        """Lead more robots, first urgent ones and those nearest to their goals."""
        _, goals, _, _, urgent = situation
        is_urgent = np.zeros(len(goals), np.bool_)
        is_urgent[urgent] = True
        rests = (self._rest > 0) & ~is_urgent
        goes = self._regions[goals[self._is_led | rests]]
        room = self._room - np.bincount(goes, minlength=len(self._room))
        free = self._most - int(self._is_led.sum())
        goes_on = (goals != situation.cells) & (distances < FAR)
        others = np.flatnonzero(~self._is_led & ~rests & goes_on)
        nearest = np.argsort(distances[others] - FAR * is_urgent[others], kind="stable")
        for robot in others[nearest].tolist():
            if free <= 0:
                break
            region = self._regions[goals[robot]]
            if room[region] > 0 or is_urgent[robot]:
                self._is_led[robot] = True
                room[region] -= 1
                free -= 1


def regions_of(graph: Graph) -> tuple[Integers, NDArray[np.float64]]:
    """Return the region of each cell, ``[H * W]``, and most robots that are led into each."""
    layout = graph.layout
    rows, columns = np.divmod(np.arange(graph.size), layout.width)
    regions = rows // REGION * -(-layout.width // REGION) + columns // REGION
    return regions, np.ceil(REGION_LED * np.bincount(regions[layout.open_cells]))
