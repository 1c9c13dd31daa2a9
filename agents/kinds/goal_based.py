"""The goal-based agent, which searches for a path to its goal on the map that it has seen.

Source: Russell and Norvig, 4th ed., section 2.4.4.
"""

from __future__ import annotations

from agents.search.algorithms import astar_search
from agents.search.belief import Belief, BeliefProblem
from agents.search.heuristics import manhattan
from agents.warehouse_agent_greedy import goal_of
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import MOVE_DELTAS, Cell, moved


class GoalBasedAgent:
    """A goal-based agent, which takes the first step of a shortest path to its goal.

    Its map contains the cells that it has seen, and it assumes that all other cells are free. It
    searches in every step, so it takes new observations into account at once. ``ExploringAgent``
    does the same with fewer searches.

    Example:
        >>> from agents import GoalBasedAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), GoalBasedAgent(), seed=12).steps
        15
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._belief, self.reason = Belief(), ""
        self._tried: tuple[Cell, Cell] | None = None

    def act(self, observation: Observation) -> str:
        """Return the first action of a plan, and set ``reason`` to the length of the plan."""
        here, goal = observation["robot_pos"], goal_of(observation)
        if self._tried is not None and self._tried[0] == here:
            self._belief.bump(self._tried[1])  # the cell counts as a wall after two failures
        self._belief.look(observation)
        self._tried, self.reason = None, "nowhere to go"
        if goal is None:
            return "WAIT"
        if here == goal:
            self.reason = "at the goal"
            return "DROP" if observation["has_item"] else "PICK"
        problem = BeliefProblem(self._belief, here, goal)
        plan = astar_search(problem, manhattan(problem))
        if not plan.found:
            return "WAIT"
        self._tried = here, moved(here, MOVE_DELTAS[plan.actions[0]])
        self.reason = f"steps to the goal: {len(plan.actions)}"
        return plan.actions[0]
