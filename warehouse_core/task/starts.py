"""Random pickups, dropoffs and starts of episodes.

The chapter's ``reset(randomize=True)`` uses Python's ``random`` so that recorded episodes can be
repeated: ``choose_stations`` and ``choose_start`` draw for it. With the other functions no episode
depends on the one before it. They serve a single warehouse and a batch, so the same random numbers
give the same episodes in both.
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
"""Allowed values of ``randomize``: randomize nothing, everything, only stations or only starts."""

MIN_OPEN_CELLS = 2
"""Number of open cells that pickup and dropoff need."""

DRAWS = 4
"""Random numbers of an episode: for pickup, dropoff, start, and the motion's seed."""

NO_RANK = -1
"""Index of a start if the stations leave no cell for it."""


class Randomized(NamedTuple):
    """The random parts of an episode: the stations, which are pickup and dropoff, and the start."""

    stations: bool
    start: bool


def randomized_parts(randomize: bool | str) -> Randomized:
    """Return the random parts for a value of ``randomize``, or raise ``ValueError``."""
    if not (isinstance(randomize, (int, str, np.bool_)) and randomize in RANDOMIZE):
        allowed = ", ".join(map(repr, RANDOMIZE))
        raise ValueError(f"randomize is {brief(randomize)}; allowed: {allowed}")
    return Randomized(randomize in (True, STATIONS), randomize in (True, START))


def check_room(layout: Layout) -> None:
    """Raise ``LayoutError`` if a layout has too few open cells for a random pickup and dropoff."""
    room = _room(layout)
    if room < MIN_OPEN_CELLS:
        without = " without a charger" if layout.chargers else ""
        raise LayoutError(
            f"randomize needs two open cells for pickup and dropoff; the layout has {room}{without}"
        )


def has_start(layout: Layout, randomized: Randomized) -> bool:
    """Return whether the stations leave a cell for a random start."""
    stations = MIN_OPEN_CELLS if randomized.stations else len(layout.pickups + layout.dropoffs)
    return _room(layout) > stations


def _room(layout: Layout) -> int:
    return len(layout.open_cells) - len(layout.chargers)


def draw_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Choose three different ``station_cells`` at random, for pickup, dropoff and start.

    Args:
        uniforms: ``[..., DRAWS]`` random numbers in [0, 1), of which the first three are used.
        counts: ``[...]`` number of ``station_cells``, at least ``MIN_OPEN_CELLS``.

    Returns:
        ``[..., 3]`` indices among the ``station_cells``. The start is ``NO_RANK`` if no cell is
        left for it.
    """
    left = np.asarray(counts)[..., None] - np.arange(3)
    ranks: NDArray[Any] = (uniforms[..., :3] * left).astype(np.intp)
    pickup, dropoff, start = ranks[..., 0], ranks[..., 1], ranks[..., 2]
    # An index among the remaining cells becomes an index among all by skipping the chosen cells.
    dropoff += dropoff >= pickup
    lower, higher = np.minimum(pickup, dropoff), np.maximum(pickup, dropoff)
    start += start >= lower
    start += start >= higher
    start[...] = np.where(left[..., 2] > 0, start, NO_RANK)
    return ranks


def draw_start_ranks(uniforms: NDArray[np.float64], counts: ArrayLike) -> NDArray[np.intp]:
    """Choose one of the ``empty_cells`` at random, for the start.

    Args:
        uniforms: ``[..., DRAWS]`` random numbers in [0, 1), of which the third is used.
        counts: ``[...]`` number of ``empty_cells``.

    Returns:
        ``[...]`` indices among the ``empty_cells``, or ``NO_RANK`` if there are none.
    """
    choices = np.asarray(counts, np.intp)
    ranks = (uniforms[..., 2] * choices).astype(np.intp)
    return np.where(choices > 0, ranks, NO_RANK)


def station_cells(layout: Layout) -> NDArray[np.intp]:
    """Return the cells that can be stations: open cells without a charger.

    The cells are numbers ``row * W + col`` in ascending order.
    """
    cells = layout.open_cells
    return np.delete(cells, layout.ranks(layout.chargers)) if layout.chargers else cells


def empty_cells(layout: Layout) -> NDArray[np.intp]:
    """Return the numbers of the open cells without a station or charger, in ascending order."""
    return np.delete(layout.open_cells, _marked(layout))


def motion_seed(uniforms: NDArray[np.float64]) -> int:
    """Return the seed of the motion, given the ``[DRAWS]`` random numbers of an episode."""
    return int(uniforms[-1] * 2**32)


def draw_episode(
    layout: Layout, uniforms: NDArray[np.float64], randomized: Randomized
) -> tuple[Layout, Cell | None]:
    """Return the layout and the start of a random episode.

    Args:
        layout: layout, which needs room for random stations, see ``check_room``.
        uniforms: ``[DRAWS]`` random numbers in [0, 1).
        randomized: random parts of the episode.

    Returns:
        The layout and the start. The start is ``None`` if it is not random, or if the stations
        leave no cell for it.
    """
    if randomized.stations:
        cells = station_cells(layout)
        pickup, dropoff, start = draw_ranks(uniforms, len(cells)).tolist()
        layout = layout.with_stations(*layout.cells(cells[[pickup, dropoff]]))
    elif randomized.start:
        cells = empty_cells(layout)
        start = int(draw_start_ranks(uniforms, len(cells)))
    if not randomized.start or start == NO_RANK:
        return layout, None
    return layout, layout.cell(cells[start])


def choose_stations(
    stream: Any, layout: Layout, taken: list[int] | None = None
) -> tuple[Layout, list[int]]:
    """Return a layout with a random pickup and dropoff, and the ranks of these two.

    Args:
        stream: Python's random stream.
        layout: layout whose empty cells are drawn from. With fewer than two empty cells, it gets no
            stations, as in the chapter's recorded episodes.
        taken: ranks of the cells that are not empty, if they are known.
    """
    check_room(layout)
    taken = _marked(layout) if taken is None else taken
    count = len(layout.open_cells)
    new: list[int] = []
    if count - len(taken) >= 2:
        for _ in range(2):
            new.append(_choose(stream, count, without=taken + new))
    pickup, dropoff = map(layout.open_cell, new) if new else (None, None)
    return layout.with_stations(pickup, dropoff), new


def choose_start(stream: Any, layout: Layout, taken: list[int] | None = None) -> Cell | None:
    """Return a random empty cell, or ``None`` if no cell is empty; see ``choose_stations``."""
    taken = _marked(layout) if taken is None else taken
    count = len(layout.open_cells)
    return layout.open_cell(_choose(stream, count, without=taken)) if count > len(taken) else None


def _marked(layout: Layout) -> list[int]:
    """Return the ranks of the stations and chargers."""
    return layout.ranks(layout.pickups + layout.dropoffs + layout.chargers)


def _choose(stream: Any, count: int, without: list[int]) -> int:
    """Return a random number of ``range(count)`` that is not in ``without``.

    The result is the same as with ``choice`` from a list of the remaining numbers, but the list is
    not built.
    """
    index: int = stream.choice(range(count - len(without)))
    for taken in sorted(without):
        index += index >= taken
    return index
