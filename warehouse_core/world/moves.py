"""Kinds of moves of a fleet: in four directions, or forward with turns on the spot.

| moves       | actions                                        |
| ----------- | ---------------------------------------------- |
| ``compass`` | the seven of ``ACTIONS``                       |
| ``turn``    | FORWARD, RIGHT, LEFT, WAIT, PICK, DROP         |

With ``turn``, each robot has a *heading*, 0 to 3 for N, E, S and W. It starts with heading east.
FORWARD moves the robot to the next cell in the direction of its heading. RIGHT and LEFT turn it by
90 degrees in its cell. Each action counts as one of ``ACTIONS``. FORWARD counts as the move in the
direction of the heading. A turn counts as a move in the new direction, except that the robot stays
in its cell and nothing blocks it.

FORWARD, RIGHT, LEFT and WAIT have the same indices as in the League of Robot Runners.
"""

from __future__ import annotations

from typing import SupportsIndex

import numpy as np

from warehouse_core.world.actions import ACTIONS, WAIT, action_index

COMPASS, TURN = "compass", "turn"
MOVES = (COMPASS, TURN)
"""Allowed values of ``moves``."""

HEADINGS = ACTIONS[:WAIT]
"""Names of the headings."""

EAST = HEADINGS.index("E")
"""Initial heading of a robot."""

FORWARD, RIGHT, LEFT = range(3)
"""Indices of the moves of a robot with a heading."""

TURN_ACTIONS = ("FORWARD", "RIGHT", "LEFT", *ACTIONS[WAIT:])


class ActionSet:
    """The actions of a robot, as words and indices.

    Attributes:
        words: word of each action.
        wait, pick, drop: indices of these three actions.
    """

    def __init__(self, words: tuple[str, ...]) -> None:
        self.words = words
        self.wait, self.pick, self.drop = map(words.index, ACTIONS[WAIT:])
        self._index_of = {word: index for index, word in enumerate(words)}

    def __len__(self) -> int:
        return len(self.words)

    def index(self, action: str | SupportsIndex) -> int:
        """Return the index of an action; see ``action_index``."""
        return action_index(action, self._index_of)


ACTION_SETS = {COMPASS: ActionSet(ACTIONS), TURN: ActionSet(TURN_ACTIONS)}

_QUARTERS = {RIGHT: 1, LEFT: -1}

HEADING_AFTER = np.array(
    [
        [(heading + _QUARTERS.get(action, 0)) % WAIT for action in range(len(TURN_ACTIONS))]
        for heading in range(WAIT)
    ]
)
"""``[heading, action]``, the heading of a robot after each action."""

COUNTS_AS = np.array(
    [
        [
            HEADING_AFTER[heading, action] if action <= LEFT else ACTIONS.index(word)
            for action, word in enumerate(TURN_ACTIONS)
        ]
        for heading in range(WAIT)
    ]
)
"""``[heading, action]``, the index in ``ACTIONS`` as which each action counts."""
