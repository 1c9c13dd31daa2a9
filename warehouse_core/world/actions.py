"""The seven actions as words, indices and displacements."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any, SupportsIndex

from warehouse_core.wording import brief
from warehouse_core.world.tiles import MOVE_DELTAS, Cell

ACTIONS = ("N", "E", "S", "W", "WAIT", "PICK", "DROP")

WAIT, PICK, DROP = (ACTIONS.index(word) for word in ("WAIT", "PICK", "DROP"))

INVALID = len(ACTIONS)
"""Index of every word or integer that is not an action."""

DISPLACEMENTS: tuple[Cell, ...] = tuple(
    MOVE_DELTAS.get(word, (0, 0)) for word in (*ACTIONS, "INVALID")
)
"""Rows and columns by which each action moves a robot, by index; ``INVALID`` is the last."""

_INDEX_OF_WORD = {word: index for index, word in enumerate(ACTIONS)}


def action_index(action: str | SupportsIndex, index_of: Mapping[str, int] = _INDEX_OF_WORD) -> int:
    """Return the index of an action given as a word in any case or as an integer.

    The index of an unknown word or an integer out of range is ``INVALID``. Such an action costs a
    step, as in the chapter.

    Args:
        action: word or integer; NumPy's integers are accepted.
        index_of: index of each allowed word, in order from 0.

    Raises:
        TypeError: ``action`` is neither a string nor an integer.
    """
    if isinstance(action, str):
        index = index_of.get(action)
        if index is None:  # some letters outside ASCII have an upper case in ASCII
            return index_of.get(action.upper() if action.isascii() else "", INVALID)
        return index
    try:
        number = operator.index(action)
    except Exception:  # a user's ``__index__`` may raise anything
        raise TypeError(
            f"action {brief(action)} is {type(action).__name__}; "
            f"allowed: one of {', '.join(index_of)} or its index 0..{len(index_of) - 1}"
        ) from None
    return number if 0 <= number < len(index_of) else INVALID


def valid_action(action: Any, count: int = INVALID) -> int:
    """Return an action given as an integer, which must be less than ``count``, as an ``int``.

    Raises:
        ValueError: it is out of range.
        TypeError: it is not an integer.
    """
    try:
        index = operator.index(action)
    except Exception:
        raise TypeError(
            f"action {brief(action)} is {type(action).__name__}; allowed: an integer 0..{count - 1}"
        ) from None
    if not 0 <= index < count:
        raise ValueError(f"action {brief(index)} is out of range; allowed: 0..{count - 1}")
    return index
