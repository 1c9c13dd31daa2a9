"""Draw pickup, dropoff and start of an episode from uniform random numbers.

The chapter's ``reset(randomize=True)`` (``warehouse_env.py``) draws from Python's ``random``, as
its recorded episodes do. Here no episode depends on the one before it, and one function draws for a
single warehouse and for a batch, so that the same numbers give the same episodes in both.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

MIN_OPEN_CELLS = 2
"""Open cells that pickup and dropoff need."""

DRAWS = 4
"""Uniform random numbers for one episode: pickup, dropoff, start, and the motion's seed."""

NO_RANK = -1
"""The rank of a start if pickup and dropoff leave no cell."""


def check_room(layout: Layout) -> None:
    """Raise if a layout has no room for pickup and dropoff.

    Raises:
        LayoutError: it has fewer open cells than ``MIN_OPEN_CELLS``.
    """
    if len(layout.open_cells) < MIN_OPEN_CELLS:
        raise LayoutError(
            f"randomize needs two open cells for pickup and dropoff; "
            f"the layout has {len(layout.open_cells)}"
        )


def draw_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Draw three different open cells, each uniformly from those not drawn yet.

    Args:
        uniforms: ``[..., DRAWS]``, in [0, 1); the first three are used.
        counts: ``[...]``, numbers of open cells, at least ``MIN_OPEN_CELLS``.

    Returns:
        ``[..., 3]`` the pickup, the dropoff and the start, as indices among the open cells. The
        start is ``NO_RANK`` if there are only two.
    """
    left = np.asarray(counts)[..., None] - np.arange(3)
    ranks: NDArray[Any] = (uniforms[..., :3] * left).astype(np.intp)
    pickup, dropoff, start = ranks[..., 0], ranks[..., 1], ranks[..., 2]
    dropoff += dropoff >= pickup
    lower, higher = np.minimum(pickup, dropoff), np.maximum(pickup, dropoff)
    start += start >= lower
    start += start >= higher
    start[...] = np.where(left[..., 2] > 0, start, NO_RANK)
    return ranks


def motion_seed(uniforms: NDArray[np.float64]) -> int:
    """Return the seed of the motion from the ``[DRAWS]`` numbers of one episode."""
    return int(uniforms[-1] * 2**32)


def draw_stations(layout: Layout, uniforms: NDArray[np.float64]) -> tuple[Layout, Cell | None]:
    """Return a layout with random pickup and dropoff, and a random start if a cell is left.

    Args:
        layout: must have room for both, see ``check_room``.
        uniforms: ``[DRAWS]``, in [0, 1).
    """
    pickup, dropoff, start = draw_ranks(uniforms, len(layout.open_cells)).tolist()
    drawn = layout.with_stations(layout.open_cell(pickup), layout.open_cell(dropoff))
    return drawn, None if start == NO_RANK else layout.open_cell(start)
