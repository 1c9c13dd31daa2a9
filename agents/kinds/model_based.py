"""The model-based reflex agent: rules on what it observes and on what it remembers.

Source: Russell and Norvig, 4th ed., section 2.4.3.
"""

from __future__ import annotations

from collections import Counter

from agents.search.belief import cells_in_view
from agents.warehouse_agent_greedy import distance, goal_of
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import MOVE_DELTAS, WALL, Cell, moved


class ModelBasedAgent:
    """A model-based reflex agent: it remembers walls, and how often it has been in each cell.

    Its model of the world is that walls stay, and that a move which leads nowhere has met one. Its
    rule is to enter the neighbour where it has been least often, and of these the nearest one.

    Example:
        >>> from agents import ModelBasedAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), ModelBasedAgent(), seed=12).steps
        25
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.reason = ""
        self._walls: set[Cell] = set()
        self._visits: Counter[tuple[Cell, Cell | None]] = Counter()
        self._tried: tuple[Cell, Cell] | None = None

    def act(self, observation: Observation) -> str:
        """Return the action of the first rule that applies, and set ``reason`` to the rule."""
        self._update_state(observation)
        here, goal = observation["robot_pos"], goal_of(observation)
        self.reason = "at the goal" if here == goal else "nowhere to go"
        if here == goal:
            return "DROP" if observation["has_item"] else "PICK"
        ways = {move: moved(here, delta) for move, delta in MOVE_DELTAS.items()}
        ways = {move: cell for move, cell in ways.items() if cell not in self._walls}
        if goal is None or not ways:
            return "WAIT"
        move = min(ways, key=lambda to: (self._visits[ways[to], goal], distance(ways[to], goal)))
        self._tried, self.reason = (here, ways[move]), "least visited"
        return move

    def _update_state(self, observation: Observation) -> None:
        here = observation["robot_pos"]
        if self._tried is not None and self._tried[0] == here:
            self._walls.add(self._tried[1])
        for cell, tile in cells_in_view(observation).items():
            (self._walls.add if tile == WALL else self._walls.discard)(cell)
        self._visits[here, goal_of(observation)] += 1
        self._tried = None
