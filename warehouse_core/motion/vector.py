"""The interface of a batch motion: one robot in each of ``B`` warehouses, moved together.

A motion with a method ``batch(layouts)`` makes one and can be the backend of ``BatchEnv``. Row
``b`` of the batch equals a separate motion in ``layouts[b]``, in ``cell`` and ``blocked``.

Here the cell of a robot is a single number, ``row * W + col``, where ``W`` is the width of its
layout.
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
"""Rows of a batch: an array of indices, or a slice."""


class BatchOutcome(NamedTuple):
    """The outcome of one action in each warehouse; the arrays belong to the caller.

    Attributes:
        cells: ``[B]`` intp, where the robots are now.
        blocked: ``[B]`` bool, whether something stopped the robot on its way to another cell.
        seconds: ``[B]`` float64, duration of each action.
        joules: ``[B]`` float64, cost of each action.
    """

    cells: NDArray[np.intp]
    blocked: Flags
    seconds: NDArray[np.float64]
    joules: NDArray[np.float64]


class BatchMotion(Protocol):
    """Moves ``B`` robots, each alone in its layout."""

    def place(self, rows: Integers, cells: Integers) -> None:
        """Put some of the robots at rest in the middle of their cells, heading east.

        Args:
            rows: ``[N]``, the robots, all different.
            cells: ``[N]``, for each of them an open cell of its layout. A backend need not check
                either.
        """

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot; all must have been placed.

        Args:
            actions: ``[B]``, indices into ``DISPLACEMENTS``.
            loaded: ``[B]``, whether the robot carries an item.

        Raises:
            RuntimeError: after ``close``.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


@runtime_checkable
class Batchable(Protocol):
    """A motion that can make a batch motion."""

    def batch(self, layouts: Sequence[Layout]) -> BatchMotion:
        """Return a motion for one robot in each of these layouts.

        Raises:
            ValueError: the settings of this motion do not allow a batch.
        """
