"""What a network learns from: views, and the moves that would have been right."""

from __future__ import annotations

import numpy as np

from agents.learning.layers import SingleFloats
from warehouse_core.world.tables import Flags


class Lessons:
    """The latest views with the moves that would have been right, at most so many.

    Args:
        most: number of views that are kept.
        shape: shape of a view.
        moves: number of moves of which some are right.
    """

    def __init__(self, most: int, shape: tuple[int, ...], moves: int) -> None:
        self._views = np.zeros((most, *shape), np.float16)
        self._right = np.zeros((most, moves), np.bool_)
        self._added = 0

    def add(self, views: SingleFloats, right: Flags) -> None:
        """Add the views for which a move is right, in place of the oldest."""
        useful = right.any(axis=1)
        places = (self._added + np.arange(useful.sum())) % len(self._views)
        self._views[places], self._right[places] = views[useful], right[useful]
        self._added += len(places)

    def draw(self, stream: np.random.Generator, count: int) -> tuple[SingleFloats, Flags]:
        """Return so many views at random, ``[count, ...]``, and what would have been right."""
        drawn = stream.integers(min(self._added, len(self._views)), size=count)
        return self._views[drawn].astype(np.float32), self._right[drawn]
