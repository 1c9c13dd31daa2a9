"""The physics backend for a batch: ``B`` warehouses with one rigid-body robot each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_core import Layout, LayoutError
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome, centre_of
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import check_open
from warehouse_core.world.tables import Flags, Integers
from warehouse_physics.batch.robots import BatchRobots
from warehouse_physics.batch.warehouses import Warehouses, corners_of
from warehouse_physics.energy import joules_of
from warehouse_physics.exclusive import exclusive
from warehouse_physics.spec import RobotSpec

ROWS_OF_A_SPACE = 256
"""Number of robots in one space. With thousands of them, a substep takes longer for each robot."""

_DISPLACEMENTS = np.array([(right, down) for down, right in DISPLACEMENTS], np.float64)


class RigidBodyBatch(BaseBatchMotion):
    """Moves one robot in each of ``B`` layouts as a disc with mass; see ``BatchMotion``.

    Up to ``ROWS_OF_A_SPACE`` robots share a space and are too far apart to touch. An action takes
    as many substeps as the slowest robot needs, but each robot has its own ``seconds`` and
    ``joules``.

    Raises:
        ValueError: there are no layouts.

    Example:
        >>> import numpy as np
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> from warehouse_physics import RobotSpec
        >>> from warehouse_physics.batch import RigidBodyBatch
        >>> batch = RigidBodyBatch(RobotSpec(), [DEFAULT_LAYOUT, DEFAULT_LAYOUT])
        >>> batch.place(np.array([0, 1]), np.array([13, 13]), [None, None])
        >>> batch.advance(np.array([1, 0]), np.array([False, False])).blocked
        array([False,  True])
    """

    changes_layouts = True
    is_busy = False

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout]) -> None:
        if not layouts:
            raise ValueError("an empty batch; it needs at least one layout")
        self.spec = spec = spec.refined()
        self._layouts = list(layouts)
        self._widths = np.array([layout.width for layout in layouts])
        self._is_placed = np.zeros(len(layouts), np.bool_)
        corners = corners_of(self._layouts, spec.cell_size)
        self._slices = [
            slice(first, first + ROWS_OF_A_SPACE)
            for first in range(0, len(layouts), ROWS_OF_A_SPACE)
        ]
        self._parts: list[BatchRobots] | None = [
            BatchRobots(spec, Warehouses(spec, self._layouts[rows], corners[rows]))
            for rows in self._slices
        ]

    def __getstate__(self) -> None:
        raise TypeError(
            "a batch of bodies can be neither copied nor pickled; create another one, reset it "
            "with the same seeds and repeat the actions"
        )

    @exclusive
    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put some of the robots at rest in a cell; see ``BatchMotion.place``.

        All calls check their arguments before they change anything. They refuse cells that are not
        open, rows that do not exist or are given twice, and arrays of the wrong length.
        """
        parts = self._in_use("place")
        rows = self._checked_rows(rows)
        cells = _checked("cells", cells, len(rows))
        starts = [self._start(*each) for each in zip(rows.tolist(), cells.tolist(), strict=True)]
        for row, start in zip(rows.tolist(), starts, strict=True):
            part, row_of_part = divmod(row, ROWS_OF_A_SPACE)
            parts[part].place(row_of_part, start)
        self._is_placed[rows] = True

    @exclusive
    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of some warehouses; see ``BaseBatchMotion.change``."""
        parts = self._in_use("change")
        rows = self._checked_rows(floors).tolist()
        for row, layout in zip(rows, layouts, strict=True):
            before = self._layouts[row]
            if (layout.height, layout.width) != (before.height, before.width):
                raise LayoutError(
                    f"the layout of floor {row} is {layout.height} x {layout.width}; it must be as "
                    f"large as the one before, {before.height} x {before.width}"
                )
        for row, layout in zip(rows, layouts, strict=True):
            part, row_of_part = divmod(row, ROWS_OF_A_SPACE)
            parts[part].arena.change_walls([row_of_part], [layout])
            self._layouts[row], self._is_placed[row] = layout, False

    @exclusive
    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action of each robot; see ``BatchMotion.advance``.

        Raises:
            RuntimeError: it is called before every row was placed, after ``close``, or while
                another call is running.
        """
        parts = self._in_use("advance")
        if not self._is_placed.all():
            missing = int(np.argmin(self._is_placed))
            raise RuntimeError(f"advance() needs a place() of every row; row {missing} had none")
        actions = _checked("actions", actions, len(self._layouts), below=len(_DISPLACEMENTS))
        loaded = _checked("loaded", loaded, len(self._layouts), kinds="b")
        for robots, rows in zip(parts, self._slices, strict=True):
            robots.drive(_DISPLACEMENTS[actions[rows]], loaded[rows])
        substeps = np.concatenate([robots.substeps for robots in parts])
        seconds = np.where(substeps > 0, substeps * self.spec.time_step, self.spec.dwell)
        work = np.concatenate([robots.work for robots in parts])
        joules = joules_of(self.spec, work, seconds)
        cols, lines = np.concatenate([robots.cells() for robots in parts]).T
        gave_up = np.concatenate([robots.gave_up for robots in parts])
        return BatchOutcome(lines * self._widths + cols, gave_up, seconds, joules)

    def close(self) -> None:
        """Release the arena; see ``BatchMotion.close``."""
        self._parts = None

    def _in_use(self, call: str) -> list[BatchRobots]:
        if self._parts is None:
            raise RuntimeError(f"{call}() after close()")
        return self._parts

    def _start(self, row: int, cell: int) -> tuple[float, float]:
        """Return the position of the middle of a cell, in metres."""
        layout = self._layouts[row]
        place = layout.cell(cell)
        check_open(layout, place, f"the robot of row {row}:")
        return centre_of(place, self.spec.cell_size)

    def _checked_rows(self, rows: Integers) -> Integers:
        rows = _checked("rows", rows, below=len(self._layouts))
        if len(set(rows.tolist())) < len(rows):
            raise ValueError(f"rows are {rows.tolist()}; each row may be given once")
        return rows


def _checked(
    name: str, values: Any, length: int | None = None, below: float = math.inf, kinds: str = "iu"
) -> Any:
    """Return ``values`` as an array ``[length]``, after a check of its shape, dtype and range.

    The dtype has to be one of ``kinds``, and the values at least 0 and less than ``below``.
    """
    array = np.asarray(values)
    if array.ndim != 1 or length not in (None, len(array)):
        wanted = "one for each row" if length is None else f"({length},)"
        raise ValueError(f"{name} have the shape {array.shape}; it must be {wanted}")
    if array.dtype.kind not in kinds:
        allowed = "bool" if kinds == "b" else "integers"
        raise ValueError(f"{name} are {array.dtype}; they must be {allowed}")
    wrong = np.flatnonzero((array < 0) | (array >= below))
    if len(wrong):
        first = int(wrong[0])
        raise ValueError(f"{name}[{first}] is {array[first]}; allowed: 0..{below - 1}")
    return array
