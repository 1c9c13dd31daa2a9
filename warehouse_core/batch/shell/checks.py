"""Checks of what environments in arrays are given: layouts, actions, masks and seeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import MAX_SEED, seed_number, sequence_of, whole_number
from warehouse_core.errors import EndedError, LayoutError
from warehouse_core.wording import brief
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.tables import Flags

Seeds = int | Sequence[int | None] | None


def checked_actions(actions: ArrayLike, rows: int, count: int) -> NDArray[np.intp]:
    """Return a checked copy of the actions, each of which is one of ``count``."""
    if isinstance(actions, range):  # which may be too long for an array
        actions = actions[: rows + 1]
    try:
        given = np.asarray(actions)
    except Exception:  # rows of different lengths, or a user's ``__array__``
        raise TypeError(f"the actions are {brief(actions)}; they must be integers") from None
    if given.dtype.kind not in "iu":
        raise TypeError(f"the actions are {given.dtype}; they must be integers")
    if given.shape != (rows,):
        raise ValueError(f"the actions have the shape {given.shape}; it must be ({rows},)")
    chosen = given.astype(np.intp)
    # As unsigned numbers, negative ones are very large.
    if chosen.view(np.uintp).max() >= count:
        row = int(np.argmax(chosen.view(np.uintp) >= count))
        raise ValueError(f"the action of row {row} is {given[row]}; allowed: 0..{count - 1}")
    return chosen


def checked_mask(mask: Flags | None, rows: int, is_first: bool) -> Flags:
    """Return a checked copy of the mask of rows to reset; ``None`` is all of them."""
    if mask is None:
        return np.ones(rows, np.bool_)
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
        raise TypeError(f"the mask is {brief(mask)}; it must be an array of bool")
    if mask.shape != (rows,) or not mask.any():
        raise ValueError(
            f"the mask has the shape {mask.shape} and {mask.sum()} rows set; "
            f"the shape must be ({rows},) and at least one row set"
        )
    if is_first:
        raise EndedError("the first reset() must be of all rows, without a mask")
    return mask.copy()


def one_layout_each(layout: Layout | Sequence[Layout] | None, rows: int) -> Sequence[Layout]:
    """Return a layout for each row, given one for all or one each; ``None`` is the chapter's."""
    if layout is None or isinstance(layout, Layout):
        return [layout or DEFAULT_LAYOUT] * rows
    if not isinstance(layout, Sequence):
        raise TypeError(f"layout is {brief(layout)}; it must be a Layout, or one for each row")
    if len(layout) != rows:
        raise ValueError(f"{len(layout)} layouts for {rows} rows; give one, or one for each row")
    for row, each in enumerate(layout):
        if not isinstance(each, Layout):
            raise TypeError(f"the layout of row {row} is {type(each).__name__}, not a Layout")
    return layout


def check_pool(pool: Sequence[Layout], layout: object, start_pos: Any) -> None:
    """Raise if layouts cannot be a pool, or other arguments cannot be given with one."""
    if layout is not None:
        raise ValueError("layout and pool are both given; allowed: one of them")
    if not sequence_of("pool", pool, Layout):
        raise ValueError("pool is empty; it needs at least one layout")
    if start_pos is not None and np.shape(start_pos) != (2,):
        raise ValueError(f"start_pos is {brief(start_pos)}; with a pool it must be one cell")
    height, width = pool[0].height, pool[0].width
    for number, each in enumerate(pool):
        if (each.height, each.width) != (height, width):
            raise LayoutError(
                f"layout {number} of the pool is {each.height} x {each.width} and layout 0 "
                f"{height} x {width}; all must have one size"
            )


def checked_seeds(seed: Seeds, rows: int) -> Sequence[int | None]:
    """Return a seed for each row: one each, consecutive ones from a first, or ``None``."""
    if seed is None:
        return [None] * rows
    if isinstance(seed, (int, np.integer)):
        first = whole_number("seed", seed, 0, MAX_SEED)
        return range(first, first + rows)
    is_array = isinstance(seed, np.ndarray) and seed.ndim == 1
    if not is_array and (not isinstance(seed, Sequence) or isinstance(seed, (str, bytes))):
        raise TypeError(f"seed is {brief(seed)}; it must be an integer or one for each row")
    if len(seed) != rows:
        raise ValueError(f"{len(seed)} seeds for {rows} rows; give one, or one for each row")
    return [seed_number(each, f"the seed of row {row}") for row, each in enumerate(seed)]
