"""The rules of the warehouse: rewards, battery, and the end of an episode.

Nothing here moves a robot. A motion backend reports the robot's cell and whether something stopped
the robot. These pure functions then compute the reward, whether the robot holds an item, how its
battery charges, and whether the episode ends. They are the same for every backend.

| action              | effect                            | reward, added to `STEP_REWARD` |
| ------------------- | --------------------------------- | ------------------------------ |
| N E S W             | the robot moves                   | 0                              |
| N E S W, blocked    | the robot stays                   | `BLOCKED_REWARD`               |
| WAIT                | none                              | `WAIT_REWARD`                  |
| WAIT on a C         | the battery gains `CHARGE` units  | `WAIT_REWARD`                  |
| PICK on a P, empty  | the robot takes the item          | `PICK_REWARD`                  |
| DROP on a D, loaded | the item is delivered; terminated | `DROP_REWARD`                  |
| any other           | none                              | `MISTAKE_REWARD`               |

Every step first costs one unit of the battery. Charging then stops at a full battery.

Source: the chapter's exercise, section 1.6 of the course book, except for the charger.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from warehouse_core.world.actions import DROP, PICK, WAIT
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP

STEP_REWARD = -0.1
BLOCKED_REWARD = -1.0
WAIT_REWARD = -0.05
PICK_REWARD = 5.0
DROP_REWARD = 10.0
MISTAKE_REWARD = -0.5

DELIVERY_REWARD = 9.0
"""Least reward of a step that delivers, in a subclass that overrides methods of the listing."""

CHARGE = 10
"""Battery units that a step on a charger adds."""


class Verdict(NamedTuple):
    """The reward and effect of one step."""

    reward: float
    has_item: bool
    delivered: bool
    charges: bool = False


# There are eight actions, five tiles and two flags, so the cache soon has the whole table.
@cache
def judge(action: int, tile: str, has_item: bool, blocked: bool) -> Verdict:
    """Return the reward and effect of one step, as in the table at the top of this file.

    Args:
        action: index into ``ACTIONS``, or ``INVALID``.
        tile: tile under the robot after its motion.
        has_item: ``True`` if the robot held an item before the step.
        blocked: ``True`` if something stopped the motion.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.task import judge
        >>> judge(WarehouseEnv.ACTIONS.index("PICK"), "P", has_item=False, blocked=False)
        Verdict(reward=4.9, has_item=True, delivered=False, charges=False)
    """
    if action < WAIT:
        return Verdict(STEP_REWARD + (BLOCKED_REWARD if blocked else 0.0), has_item, False)
    if action == WAIT:
        return Verdict(STEP_REWARD + WAIT_REWARD, has_item, False, tile == CHARGER)
    if action == PICK and tile == PICKUP and not has_item:
        return Verdict(STEP_REWARD + PICK_REWARD, True, False)
    if action == DROP and tile == DROPOFF and has_item:
        return Verdict(STEP_REWARD + DROP_REWARD, False, True)
    return Verdict(STEP_REWARD + MISTAKE_REWARD, has_item, False)


@cache
def useful_actions(open_sides: tuple[bool, ...], tile: str, has_item: bool) -> tuple[bool, ...]:
    """Return a flag for each action that has an effect; other actions only cost a penalty.

    Args:
        open_sides: flags of the open neighbours to the N, E, S and W.
        tile: tile under the robot.
        has_item: ``True`` if the robot holds an item.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.task import useful_actions
        >>> is_useful = useful_actions((False, True, True, False), "P", has_item=False)
        >>> [action for action, useful in zip(WarehouseEnv.ACTIONS, is_useful) if useful]
        ['E', 'S', 'WAIT', 'PICK']
    """
    # This calls ``judge``, so that masks and rewards cannot disagree.
    picks = judge(PICK, tile, has_item, False).has_item != has_item
    return (*open_sides, True, picks, judge(DROP, tile, has_item, False).delivered)


def charged(battery: int, max_battery: int) -> int:
    """Return the battery units after charging, given the units left after the step's cost."""
    return min(max_battery, battery + CHARGE)


def is_truncated(steps: int, max_steps: int, battery: int) -> bool:
    """Return whether an episode is truncated because its steps or the battery are used up."""
    return steps >= max_steps or battery <= 0
