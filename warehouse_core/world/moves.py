"""How the robots of a fleet move: in four directions, or forward with turns on the spot.

| moves       | actions                                        |
| ----------- | ---------------------------------------------- |
| ``compass`` | the seven of ``ACTIONS``                       |
| ``turn``    | FORWARD, RIGHT, LEFT, WAIT, PICK, DROP         |

With ``turn``, each robot has a *heading*, 0 to 3 for N, E, S and W, at first east. FORWARD moves it
to the cell that it heads for; RIGHT and LEFT turn it by a quarter in its cell. Each action counts
as one of ``ACTIONS``: FORWARD as the move in the direction of the heading, and a turn as a move in
its new direction, except that the robot stays in its cell and nothing blocks it.

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
"""Words of the headings."""

EAST = HEADINGS.index("E")
"""Heading of a robot at the start."""

FORWARD, RIGHT, LEFT = range(3)
"""Indices of the moves of a robot with a heading."""

TURN_ACTIONS = ("FORWARD", "RIGHT", "LEFT", *ACTIONS[WAIT:])


class ActionSet:
    """The actions of a robot.

    Attributes:
        words: word of each action.
        wait, pick, drop: indices of three of them.
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
"""Heading after each action, by the heading before it."""

COUNTS_AS = np.array(
    [
        [
            HEADING_AFTER[heading, action] if action <= LEFT else ACTIONS.index(word)
            for action, word in enumerate(TURN_ACTIONS)
        ]
        for heading in range(WAIT)
    ]
)
"""Index in ``ACTIONS`` of what each action counts as, by the heading before it."""
