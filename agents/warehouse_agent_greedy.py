"""The chapter's greedy agent, which reduces the Manhattan distance and escapes from loops.

It is a simple goal-based agent with internal state: its goal is a cell, and its state is its
positions in the last steps. It uses nothing but the observation. For the chapter's question about
escaping from loops, switch the escape off with ``escape_steps=0``.

Source: the chapter's exercise, section 1.6.4 of the course book.
"""

from __future__ import annotations

import random
from collections import deque

from warehouse_core.arguments import MAX_STEPS, seed_number, whole_number
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import MOVE_DELTAS, WALL, Cell


class GreedyAgent:
    """A greedy agent, which takes the item from the pickup to the dropoff.

    It takes a move that reduces the Manhattan distance to its goal. If no open move does, it is
    stuck and takes a random open move. If it revisits one of its last ``memory`` positions on the
    path to this goal, it assumes that it is in a loop and takes random open moves for
    ``escape_steps`` steps.

    Args:
        seed: seed of the agent's own random stream, restarted at each ``reset``; ``None`` uses
            Python's global ``random``, as in the chapter.
        memory: number of positions that it remembers, at least 0.
        escape_steps: number of random moves in an escape; 0 disables escaping.

    Raises:
        ValueError: an argument is negative or larger than ``MAX_STEPS``.
        TypeError: an argument is not an integer.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv
        >>> agent = GreedyAgent(seed=12)
        >>> agent.act(WarehouseEnv().reset()), agent.reason
        ('E', 'greedy')
    """

    def __init__(self, seed: int | None = None, memory: int = 10, escape_steps: int = 3) -> None:
        self.seed = seed_number(seed)
        self.memory = whole_number("memory", memory, 0, MAX_STEPS)
        self.escape_steps = whole_number("escape_steps", escape_steps, 0, MAX_STEPS)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self._random = random if self.seed is None else random.Random(self.seed)
        self._visited: deque[Cell] = deque(maxlen=self.memory)
        self._escape_left = 0
        self._had_item = False
        self.reason = ""

    def act(self, observation: Observation) -> str:
        """Return the action for ``observation``, and set ``reason`` to the reason for it.

        The reason is ``"greedy"``, ``"stuck"`` or ``"escape"``, or ``"no goal"`` if the layout has
        no pickup or dropoff to go to.
        """
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = goal_of(observation)
        looping = self._notice_loop(here, has_item)
        if goal is None:
            return self._choose("no goal", "WAIT")
        if here == goal:
            return self._choose("greedy", "DROP" if has_item else "PICK")
        moves = open_moves(observation["local_grid"])
        if looping or self._escape_left:
            self._escape_left = (self._escape_left or self.escape_steps) - 1
            return self._choose("escape", *moves)
        closer = [move for move in moves if distance_after(move, here, goal) < distance(here, goal)]
        return self._choose("greedy", closer[0]) if closer else self._choose("stuck", *moves)

    def _notice_loop(self, here: Cell, has_item: bool) -> bool:
        """Remember ``here`` and return whether it is among the remembered positions."""
        if has_item != self._had_item:
            self._visited.clear()
            self._had_item = has_item
        looping = here in self._visited and self.escape_steps > 0
        self._visited.append(here)
        return looping

    def _choose(self, reason: str, *actions: str) -> str:
        self.reason = reason
        if len(actions) < 2:
            return actions[0] if actions else "WAIT"
        return self._random.choice(actions)


def goal_of(observation: Observation) -> Cell | None:
    """Return the pickup, or the dropoff if the robot holds the item; ``None`` if there is none."""
    return observation["dropoff_pos"] if observation["has_item"] else observation["pickup_pos"]


def distance(a: Cell, b: Cell) -> int:
    """Return the Manhattan distance ``|x1 - x2| + |y1 - y2|`` in cells."""
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def distance_after(move: str, here: Cell, goal: Cell) -> int:
    """Return the Manhattan distance to ``goal`` after ``move`` from ``here``."""
    down, right = MOVE_DELTAS[move]
    return distance((here[0] + down, here[1] + right), goal)


def open_moves(local_grid: list[str]) -> list[str]:
    """Return the moves that no wall in view blocks; all four if the view radius is 0."""
    centre = len(local_grid) // 2
    if centre == 0:
        return list(MOVE_DELTAS)
    return [
        move
        for move, (down, right) in MOVE_DELTAS.items()
        if local_grid[centre + down][centre + right] != WALL
    ]
