"""Planners for robots whose goals change: they choose the next cell of each, step by step."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Integers


class Situation(NamedTuple):
    """What a planner knows of ``R`` robots before a joint step; cells are numbers.

    Attributes:
        cells: ``[R]``, where they are, all different.
        goals: ``[R]``, where they are to go; several may have one goal. A robot that is to go
            nowhere has its own cell as goal, and gives way.
        stays: ``[R]``, whether a robot stays where it is in this step, as one does that picks,
            drops or charges, or whose battery is empty.
        closed: cells that nobody can enter in this step, such as those of people.
    """

    cells: Integers
    goals: Integers
    stays: NDArray[np.bool_]
    closed: Integers


class Planner(Protocol):
    """Chooses the next cells of robots; each planner is made for one ``Graph``."""

    def reset(self) -> None:
        """Forget the last episode."""

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step, ``[R]``.

        The step has no conflict: no two robots in one cell, no two that change places, nobody in
        a closed cell. Each cell is the robot's own or one beside it.
        """
