"""The history of a robot in the frames of a track: visited cells, skids, pickups, deliveries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from warehouse_core.render.palette import LOOK
from warehouse_core.viz.tracks.track import Frame, Point
from warehouse_core.world.tiles import Cell


def skids_of(frames: Sequence[Frame], robot: int) -> Iterator[tuple[int, list[Point]]]:
    """Yield the lines of skid marks of a robot, each with the number of the frame where it ends."""
    for number, (before, after) in enumerate(pairwise(frames), start=1):
        start, end = before.robots[robot], after.robots[robot]
        if start is None or end is None or end.push is None or not end.push.skids:
            continue
        (x, y), (to_x, to_y) = start.at, end.at
        apart = LOOK["skid"]["apart"] / max(math.dist(start.at, end.at), 1e-9)
        for side in (-apart, apart):
            right, down = side * (y - to_y), side * (to_x - x)
            yield number, [(x + right, y + down), (to_x + right, to_y + down)]


class History:
    """The cells of a single robot after each step, and its pickups and deliveries.

    Attributes:
        frames: number of the frame at the end of each step.
        cells: cell of the robot at the end of each step.
        taken: numbers of the frames in which the robot has just picked up an item.
        delivered: numbers of the frames in which the robot has just dropped an item, each with the
            cell of the item.
        starts_loaded: true if the robot has an item in the first frame.
    """

    def __init__(self) -> None:
        self._read = 0
        self.frames: list[int] = []
        self.cells: list[Cell | None] = []
        self.taken: list[int] = []
        self.delivered: list[tuple[int, Cell]] = []
        self._was_loaded: bool | None = None
        self.starts_loaded = False

    def read(self, frames: Sequence[Frame]) -> None:
        """Read the frames that have not been read yet."""
        for number in range(self._read, len(frames)):
            pose = frames[number].robots[0]
            cell = None if pose is None else (int(pose.at[1]), int(pose.at[0]))
            if frames[number].progress.is_integer():
                self.frames.append(number)
                self.cells.append(cell)
            if pose is None or cell is None:
                continue
            if self._was_loaded is None:
                self.starts_loaded = pose.loaded
            elif pose.loaded and not self._was_loaded:
                self.taken.append(number)
            elif self._was_loaded and not pose.loaded:
                self.delivered.append((number, cell))
            self._was_loaded = pose.loaded
        self._read = max(self._read, len(frames))

    def entries(self, step: int) -> dict[Cell, list[int]]:
        """Return the frames in which the robot entered each cell in the first ``step`` steps."""
        entries: dict[Cell, list[int]] = {}
        before: Cell | None = None
        for number, cell in zip(self.frames[: step + 1], self.cells, strict=False):
            if cell is not None and cell != before:
                entries.setdefault(cell, []).append(number)
            before = cell
        return entries
