"""Draw pickup, dropoff and start of an episode from uniform random numbers.

The chapter's ``reset(randomize=True)`` (``warehouse_env.py``) draws from Python's ``random``, as
its recorded episodes do. Here no episode depends on the one before it, and one function draws for a
single warehouse and for a batch, so that the same numbers give the same episodes in both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

STATIONS, START = "stations", "start"
RANDOMIZE = (False, True, STATIONS, START)
"""Allowed values of ``randomize``: draw nothing, all, or one of the two."""

MIN_OPEN_CELLS = 2
"""Open cells that pickup and dropoff need."""

DRAWS = 4
"""Uniform random numbers for one episode: pickup, dropoff, start, and the motion's seed."""

NO_RANK = -1
"""Rank of a start for which the stations leave no cell."""


class Drawn(NamedTuple):
    """Whether pickup and dropoff are drawn, and whether the start is."""

    stations: bool
    start: bool


def what_is_drawn(randomize: bool | str) -> Drawn:
    """Return what ``randomize`` stands for; raise ``ValueError`` if it is not allowed."""
    is_flag = randomize is False or randomize is True
    if not is_flag and not (isinstance(randomize, (int, str, np.bool_)) and randomize in RANDOMIZE):
        allowed = ", ".join(map(repr, RANDOMIZE))
        raise ValueError(f"randomize is {brief(randomize)}; allowed: {allowed}")
    return Drawn(randomize in (True, STATIONS), randomize in (True, START))


def check_room(layout: Layout) -> None:
    """Raise ``LayoutError`` if a layout has no room for pickup and dropoff, beside chargers."""
    room = _room(layout)
    if room < MIN_OPEN_CELLS:
        beside = " beside its chargers" if layout.chargers else ""
        raise LayoutError(
            f"randomize needs two open cells for pickup and dropoff; the layout has {room}{beside}"
        )


def has_start(layout: Layout, drawn: Drawn) -> bool:
    """Return whether the stations leave a cell to draw a start from."""
    stations = MIN_OPEN_CELLS if drawn.stations else len(layout.pickups + layout.dropoffs)
    return _room(layout) > stations


def _room(layout: Layout) -> int:
    return len(layout.open_cells) - len(layout.chargers)


def draw_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Draw three different ``station_cells``, each uniformly from those not drawn yet.

    Their numbers are ``counts``, ``[...]`` and at least ``MIN_OPEN_CELLS``; of the ``uniforms``,
    ``[..., DRAWS]`` in [0, 1), the first three are used. Return the indices of pickup, dropoff and
    start, ``[..., 3]``; the start is ``NO_RANK`` if no cell is left for it.
    """
    left = np.asarray(counts)[..., None] - np.arange(3)
    ranks: NDArray[Any] = (uniforms[..., :3] * left).astype(np.intp)
    pickup, dropoff, start = ranks[..., 0], ranks[..., 1], ranks[..., 2]
    # A rank among the cells that are left becomes one among all: it skips the cells drawn before.
    dropoff += dropoff >= pickup
    lower, higher = np.minimum(pickup, dropoff), np.maximum(pickup, dropoff)
    start += start >= lower
    start += start >= higher
    start[...] = np.where(left[..., 2] > 0, start, NO_RANK)
    return ranks


def draw_start_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Draw a cell uniformly from the ``empty_cells``, of which there are ``counts``, ``[...]``.

    Return its index among them, by the number of the start, or ``NO_RANK`` if there are none.
    """
    choices = np.asarray(counts, np.intp)
    ranks = (uniforms[..., 2] * choices).astype(np.intp)
    return np.where(choices > 0, ranks, NO_RANK)


def station_cells(layout: Layout) -> NDArray[np.intp]:
    """Return the cells for stations: the open ones without a charger, in ascending order.

    Cells are ``row * W + col``.
    """
    cells = layout.open_cells
    return np.delete(cells, layout.ranks(layout.chargers)) if layout.chargers else cells


def empty_cells(layout: Layout) -> NDArray[np.intp]:
    """Return the open cells without a station or a charger, in the same form."""
    marked = layout.pickups + layout.dropoffs + layout.chargers
    return np.delete(layout.open_cells, layout.ranks(marked))


def motion_seed(uniforms: NDArray[np.float64]) -> int:
    """Return the seed of the motion from the ``[DRAWS]`` numbers of one episode."""
    return int(uniforms[-1] * 2**32)


def draw_episode(
    layout: Layout, uniforms: NDArray[np.float64], drawn: Drawn
) -> tuple[Layout, Cell | None]:
    """Return the layout and the start of an episode, drawn by ``[DRAWS]`` numbers.

    A layout whose stations are drawn needs room, see ``check_room``. The start is ``None`` if it is
    not drawn, or the stations leave no cell.
    """
    if drawn.stations:
        cells = station_cells(layout)
        pickup, dropoff, start = draw_ranks(uniforms, len(cells)).tolist()
        layout = layout.with_stations(*layout.cells(cells[[pickup, dropoff]]))
    elif drawn.start:
        cells = empty_cells(layout)
        start = int(draw_start_ranks(uniforms, len(cells)))
    if not drawn.start or start == NO_RANK:
        return layout, None
    return layout, layout.cell(cells[start])
