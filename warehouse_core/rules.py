"""The rules of the warehouse: what an action earns, and when an episode ends.

Nothing here moves a robot. A motion backend says where the robot came to rest and whether
something stopped it; these pure functions turn that into a reward, a cargo and an ending. They
know no backend, so every backend is judged alike.

| action                       | effect               | reward beside the step's -0.1 |
| ---------------------------- | -------------------- | ----------------------------- |
| N E S W, not blocked         | the robot moves      |  0                            |
| N E S W, blocked             | the robot stays      | -1.0                          |
| WAIT                         |                      | -0.05                         |
| PICK on a P, hands empty     | takes the item       | +5.0                          |
| PICK otherwise               |                      | -0.5                          |
| DROP on a D, loaded          | delivers, terminated | +10.0                         |
| DROP otherwise               | keeps what it holds  | -0.5                          |
| anything else                | nothing              | -0.5                          |

Source: the chapter's exercise (Russell and Norvig, 4th ed., ch. 2).
"""

from __future__ import annotations

import operator
from functools import cache
from typing import Any, NamedTuple, SupportsIndex

from warehouse_core.layout import DROPOFF, MOVE_DELTAS, PICKUP, Cell

ACTIONS = ("N", "E", "S", "W", "WAIT", "PICK", "DROP")
WAIT, PICK, DROP = (ACTIONS.index(word) for word in ("WAIT", "PICK", "DROP"))
INVALID = len(ACTIONS)
"""The index that stands for every word and integer that is no action."""

DISPLACEMENTS: tuple[Cell, ...] = tuple(
    MOVE_DELTAS.get(word, (0, 0)) for word in (*ACTIONS, "INVALID")
)
"""Rows and columns that each action asks for, by index, ``INVALID`` last."""

STEP_REWARD = -0.1
BLOCKED_REWARD = -1.0
WAIT_REWARD = -0.05
PICK_REWARD = 5.0
DROP_REWARD = 10.0
MISTAKE_REWARD = -0.5

_INDEX_OF_WORD = {word: index for index, word in enumerate(ACTIONS)}


class Verdict(NamedTuple):
    """What one step came to."""

    reward: float
    has_item: bool
    delivered: bool


def action_index(action: str | SupportsIndex) -> int:
    """Return the index of an action given as a word (any case) or an integer (NumPy's too).

    An unknown word or an integer out of range is ``INVALID``: it costs a step, as in the chapter.

    Raises:
        TypeError: ``action`` is neither a word nor an integer.
    """
    if isinstance(action, str):
        index = _INDEX_OF_WORD.get(action)
        if index is None:  # some letters beyond ASCII have an upper case within it
            return _INDEX_OF_WORD.get(action.upper() if action.isascii() else "", INVALID)
        return index
    try:
        number = operator.index(action)
    except TypeError:
        raise TypeError(
            f"action {action!r} is {type(action).__name__}; allowed: one of {', '.join(ACTIONS)} "
            f"or its index 0..{INVALID - 1}"
        ) from None
    return number if 0 <= number < INVALID else INVALID


def valid_action(action: Any) -> int:
    """Return the index of an action that must be one, and given as an integer.

    Raises:
        ValueError: it is out of range.
        TypeError: it is not an integer.
    """
    try:
        index = operator.index(action)
    except TypeError:
        raise TypeError(
            f"action {action!r} is {type(action).__name__}; allowed: an integer 0..{INVALID - 1}"
        ) from None
    if not 0 <= index < INVALID:
        raise ValueError(f"action {index} is out of range; allowed: 0..{INVALID - 1}")
    return index


@cache
def judge(action: int, tile: str, has_item: bool, blocked: bool) -> Verdict:
    """Judge one step: the table at the top of this file.

    Args:
        action: index into ``ACTIONS``, or ``INVALID``.
        tile: the tile under the robot after its motion.
        has_item: whether the robot held an item before the step.
        blocked: whether something stopped the motion.
    """
    if action < WAIT:
        return Verdict(STEP_REWARD + (BLOCKED_REWARD if blocked else 0.0), has_item, False)
    if action == WAIT:
        return Verdict(STEP_REWARD + WAIT_REWARD, has_item, False)
    if action == PICK and tile == PICKUP and not has_item:
        return Verdict(STEP_REWARD + PICK_REWARD, True, False)
    if action == DROP and tile == DROPOFF and has_item:
        return Verdict(STEP_REWARD + DROP_REWARD, False, True)
    return Verdict(STEP_REWARD + MISTAKE_REWARD, has_item, False)


@cache
def useful_actions(open_sides: tuple[bool, ...], tile: str, has_item: bool) -> tuple[bool, ...]:
    """Say of each action whether it does something: whatever else only costs its penalty.

    Args:
        open_sides: whether the neighbouring cell can be driven to, in the order N E S W.
        tile: the tile under the robot.
        has_item: whether the robot holds an item.
    """
    picks = judge(PICK, tile, has_item, False).has_item != has_item
    return (*open_sides, True, picks, judge(DROP, tile, has_item, False).delivered)


def is_truncated(steps: int, max_steps: int, battery: int) -> bool:
    """Say whether an episode is cut off: the steps or the battery are used up."""
    return steps >= max_steps or battery <= 0
