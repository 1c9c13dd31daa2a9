"""The seam of ``base.py`` for a batch: one robot in each of ``B`` warehouses, moved together.

What carries out the moves of a batch is made by the motion that it multiplies: a motion with a
method ``batch(layouts)`` can be given as the backend of ``BatchEnv``. Row ``b`` of a batch is what
a motion of its own would do in ``layouts[b]``, equal in ``cell`` and ``blocked``.

The cell of a robot is a single number here, ``row * W + col`` with ``W`` the width of its layout.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.layout import Layout

Integers = NDArray[np.integer]
Flags = NDArray[np.bool_]
Rows = Integers | slice
"""Rows of a batch: some by their numbers, or all."""


class BatchOutcome(NamedTuple):
    """What carrying out one action in each warehouse came to; nothing in it is used again.

    Attributes:
        cells: ``[B]`` intp, where the robots are now.
        blocked: ``[B]`` bool, something stopped the robot on its way to another cell.
        seconds: ``[B]`` float64, how long it took.
        joules: ``[B]`` float64, what it cost.
    """

    cells: NDArray[np.intp]
    blocked: Flags
    seconds: NDArray[np.float64]
    joules: NDArray[np.float64]


class BatchMotion(Protocol):
    """Moves ``B`` lone robots, each in a layout of its own."""

    def place(self, rows: Integers, cells: Integers) -> None:
        """Put some of the robots at rest in the middle of a cell, heading east.

        Args:
            rows: ``[N]``, which robots, no two alike.
            cells: ``[N]``, for each of them an open cell of its layout; a backend may take both
                on trust.
        """

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot, all of which have been placed.

        Args:
            actions: ``[B]``, indices into ``rules.DISPLACEMENTS``.
            loaded: ``[B]``, whether the robot carries an item.

        Raises:
            RuntimeError: after ``close``.
        """

    def close(self) -> None:
        """Let go of whatever the backend holds; a second call does nothing."""


@runtime_checkable
class Batchable(Protocol):
    """A motion that can be multiplied."""

    def batch(self, layouts: Sequence[Layout]) -> BatchMotion:
        """Return a motion for one robot in each of these layouts.

        Raises:
            ValueError: this motion is of a kind that can be multiplied, but as it is it cannot.
        """
