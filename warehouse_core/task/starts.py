"""Where an episode takes place: pickup, dropoff and start, from uniform numbers.

The chapter's ``reset(randomize=True)`` draws as its recorded episodes do, from Python's ``random``
(``warehouse_env.py``). Here no episode depends on the one before it, and one function draws for a
single warehouse and for a batch, so that both come to the same from the same numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

NEEDED = 2
"""Open cells without which there is no room for pickup and dropoff."""

DRAWS = 4
"""Uniform numbers that one episode takes: for pickup, dropoff, start, and the motion's chance."""

NO_RANK = -1
"""Stands for a start where pickup and dropoff have left no cell."""


def check_room(layout: Layout) -> None:
    """Refuse a layout without room for pickup and dropoff.

    Raises:
        LayoutError: it has fewer open cells than ``NEEDED``.
    """
    if len(layout.open_cells) < NEEDED:
        raise LayoutError(
            f"randomize needs two open cells for pickup and dropoff; "
            f"the layout has {len(layout.open_cells)}"
        )


def draw_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Draw three different open cells, each uniform over what those before it leave.

    Args:
        uniforms: ``[..., DRAWS]``, in [0, 1), of which the first three count here.
        counts: ``[...]``, how many open cells there are, at least ``NEEDED``.

    Returns:
        ``[..., 3]`` the pickup, the dropoff and the start, as indices among the open cells. The
        start is ``NO_RANK`` where there are but two.
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
    """Return the seed of the motion's chance from the ``[DRAWS]`` numbers of one episode."""
    return int(uniforms[-1] * 2**32)


def draw_stations(layout: Layout, uniforms: NDArray[np.float64]) -> tuple[Layout, Cell | None]:
    """Return a layout with pickup and dropoff drawn into it, and the start if a cell is left.

    Args:
        layout: with room for both, see ``check_room``.
        uniforms: ``[DRAWS]``, in [0, 1).
    """
    pickup, dropoff, start = draw_ranks(uniforms, len(layout.open_cells)).tolist()
    drawn = layout.with_stations(layout.open_cell(pickup), layout.open_cell(dropoff))
    return drawn, None if start == NO_RANK else layout.open_cell(start)
