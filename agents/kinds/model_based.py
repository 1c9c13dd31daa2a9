"""The model-based reflex agent, whose rules use its observation and its memory.

Source: Russell and Norvig, 4th ed., section 2.4.3.
"""

from __future__ import annotations

from collections import Counter

from agents.search.belief import cells_in_view
from agents.warehouse_agent_greedy import distance, goal_of
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import MOVE_DELTAS, WALL, Cell, moved


class ModelBasedAgent:
    """A model-based reflex agent, which remembers walls and counts its visits to each cell.

    Its model of the world says that walls do not move, and that a move without effect has hit one.
    Its rule is to enter the neighbouring cell that it has visited least often with its present
    goal. Among several such cells, it takes the one nearest to the goal.

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
        cells = {move: moved(here, delta) for move, delta in MOVE_DELTAS.items()}
        cells = {move: cell for move, cell in cells.items() if cell not in self._walls}
        if goal is None or not cells:
            return "WAIT"
        move = min(cells, key=lambda to: (self._visits[cells[to], goal], distance(cells[to], goal)))
        self._tried, self.reason = (here, cells[move]), "least visited"
        return move

    def _update_state(self, observation: Observation) -> None:
        here = observation["robot_pos"]
        if self._tried is not None and self._tried[0] == here:
            self._walls.add(self._tried[1])
        for cell, tile in cells_in_view(observation).items():
            (self._walls.add if tile == WALL else self._walls.discard)(cell)
        self._visits[here, goal_of(observation)] += 1
        self._tried = None
