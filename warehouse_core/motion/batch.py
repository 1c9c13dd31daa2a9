"""The interface of a batch motion: ``R`` robots in each of ``B`` warehouses, moved together.

A motion with a method ``batch(layouts)`` makes one of lone robots and can be the backend of
``BatchEnv``; one with a method ``fleet_batch(layouts, robots)`` moves fleets by arrays too. Floor
``b`` of the batch equals a separate motion in ``layouts[b]``, in ``cell`` and ``blocked``.

The arrays have a row for each of the ``N = B * R`` robots, floor by floor: robot ``r`` of floor
``b`` is row ``b * R + r``. Here the cell of a robot is a single number, ``row * W + col``, where
``W`` is the width of its layout.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.base import Motion, Outcome
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers

NOTHING, WALL = -1, -2
"""Values of ``stopped_by`` besides the robots of the floor, which have numbers from 0."""


class BatchOutcome(NamedTuple):
    """The outcome of one action of each robot; the arrays belong to the caller.

    Attributes:
        cells: ``[N]`` intp, where the robots are now.
        blocked: ``[N]`` bool, whether something stopped the robot on its way to another cell.
        seconds: ``[N]`` float64, duration of each action.
        joules: ``[N]`` float64, cost of each action.
        stopped_by: ``[N]`` intp, what stopped the robot: ``NOTHING``, ``WALL``, or the number of
            another robot on its floor. ``None`` if robots are alone and only walls block them.
        ends: ``[N]`` intp, where their next moves begin, of a motion that ``DrivesThrough``.
            ``None``: where they are.
        driving: ``[N]`` bool, whether the robot has not come to rest, so that it can neither pick,
            drop nor charge. ``None``: all are at rest after each action.
        failed: ``[N]`` bool, whether the robot stays where it is for good. ``None``: none can.

    Example:
        >>> import numpy as np
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> motion = GridMotion().batch([DEFAULT_LAYOUT, DEFAULT_LAYOUT])
        >>> motion.place(np.array([0, 1]), np.array([13, 14]), [None, None])
        >>> outcome = motion.advance(np.array([1, 0]), np.array([False, False]))
        >>> outcome.cells, outcome.blocked
        (array([14, 14]), array([False,  True]))
    """

    cells: NDArray[np.intp]
    blocked: Flags
    seconds: NDArray[np.float64]
    joules: NDArray[np.float64]
    stopped_by: NDArray[np.intp] | None = None
    ends: NDArray[np.intp] | None = None
    driving: Flags | None = None
    failed: Flags | None = None


class BatchMotion(Protocol):
    """Moves ``R`` robots in each of ``B`` layouts.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> from warehouse_core.motion import BatchMotion
        >>> motion: BatchMotion = GridMotion().batch([DEFAULT_LAYOUT, DEFAULT_LAYOUT])
    """

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put the robots of some floors at rest in the middle of their cells, heading east.

        Args:
            rows: ``[F * R]``, all robots of ``F`` different floors, in order on each floor.
            cells: ``[F * R]``, for each of them an open cell of its layout, on a floor all
                different. A backend need not check either.
            seeds: ``F``, for the backend's random numbers on each of these floors; ``None`` lets
                the backend choose.
        """

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot; all must have been placed.

        Args:
            actions: ``[N]``, indices into ``DISPLACEMENTS``.
            loaded: ``[N]``, whether the robot carries an item.

        Raises:
            RuntimeError: after ``close``.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


class FleetBatchMotion(BatchMotion, Protocol):
    """A batch motion that also tells what stopped each robot, and how each moved."""

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return what the last ``advance`` did on one floor, with paths and contacts.

        Raises:
            RuntimeError: the robots of the floor have not moved since they were placed.
        """


@runtime_checkable
class ChangesLayouts(Protocol):
    """A batch motion whose floors can get other layouts, for ``BatchEnv(pool=...)``."""

    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of different floors by others of their sizes.

        The robots there must be placed before they move.
        """


@runtime_checkable
class CanFail(Protocol):
    """A batch motion whose robots may fail."""

    def fail(self, rows: Integers) -> None:
        """Let robots stay where they are for good."""


@runtime_checkable
class CanTurn(Protocol):
    """A batch motion whose robots can turn on the spot."""

    def face(self, actions: Integers) -> None:
        """Let robots that stay in their cells in the next ``advance`` turn in it.

        Args:
            actions: ``[N]``, indices into ``DISPLACEMENTS`` of the directions that the robots turn
                to; ``WAIT`` for those that do not turn.
        """


@runtime_checkable
class Batchable(Protocol):
    """A motion that can move one robot in each of many layouts by arrays.

    Example:
        >>> from warehouse_core import GridMotion
        >>> from warehouse_core.motion import Batchable
        >>> isinstance(GridMotion(), Batchable)
        True
    """

    def batch(self, layouts: Sequence[Layout]) -> BatchMotion:
        """Return a motion for a lone robot in each of these layouts.

        Raises:
            ValueError: the settings of this motion do not allow a batch.
        """


@runtime_checkable
class FleetBatchable(Protocol):
    """A motion that can move the fleets of many layouts by arrays."""

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> FleetBatchMotion:
        """Return a motion for so many robots, at least 1, in each of these layouts.

        Raises:
            ValueError: the settings of this motion do not allow a batch of so many robots.
        """


def is_outdated(motion: Motion, method: str) -> bool:
    """Return whether a method that makes batches comes from a class whose ``advance`` is not used.

    A subclass that overrides ``advance`` alone inherits batches that move as its parent does.
    """
    kinds = type(motion).__mro__
    nearest = {name: kind for kind in reversed(kinds) for name in vars(kind)}
    return kinds.index(nearest["advance"]) < kinds.index(nearest.get(method, kinds[0]))
