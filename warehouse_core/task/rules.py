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

from functools import cache
from typing import NamedTuple

from warehouse_core.world.actions import DROP, PICK, WAIT
from warehouse_core.world.tiles import DROPOFF, PICKUP

STEP_REWARD = -0.1

BLOCKED_REWARD = -1.0

WAIT_REWARD = -0.05

PICK_REWARD = 5.0

DROP_REWARD = 10.0

MISTAKE_REWARD = -0.5


class Verdict(NamedTuple):
    """What one step came to."""

    reward: float
    has_item: bool
    delivered: bool


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
