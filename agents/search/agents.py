"""Agents that plan by searching: one that knows the map, and one that explores it.

Source: Russell and Norvig, 4th ed., ch. 3, and section 4.5 on online search.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from agents.search.algorithms import (
    Solution,
    astar_search,
    breadth_first_search,
    check_weight,
    greedy_best_first_search,
    uniform_cost_search,
    weighted_astar_search,
)
from agents.search.belief import Belief, BeliefProblem
from agents.search.costs import STEPS, action_costs
from agents.search.heuristics import manhattan, manhattan_delivery
from agents.search.problems import DeliveryProblem, DeliveryState
from agents.warehouse_agent_greedy import goal_of
from warehouse_core.arguments import flag, instance_of, one_of
from warehouse_core.motion.backends import Backend
from warehouse_core.task.state import Observation
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import MOVE_DELTAS, Cell, moved

WEIGHT = 2.0
"""Default weight of the heuristic in weighted A*."""

PATIENCE = 10
"""Number of times per goal that an exploring agent discards the walls that it only assumes."""

ALGORITHMS: dict[str, Callable[[DeliveryProblem, float], Solution[DeliveryState, str]]] = {
    "bfs": lambda problem, _: breadth_first_search(problem),
    "ucs": lambda problem, _: uniform_cost_search(problem),
    "greedy-best-first": lambda problem, _: greedy_best_first_search(
        problem, manhattan_delivery(problem)
    ),
    "astar": lambda problem, _: astar_search(problem, manhattan_delivery(problem)),
    "weighted-astar": lambda problem, weight: weighted_astar_search(
        problem, manhattan_delivery(problem), weight
    ),
}
"""Functions that plan a delivery, by name. Only weighted A* uses the weight."""


class SearchAgent:
    """An agent that knows the map, plans the whole delivery once, and follows the plan.

    If a motion leads off the plan, the agent makes a new plan. If there is no path, it waits. An
    agent that does not replan carries out its first plan without looking where it is, and then
    waits.

    Args:
        layout: layout with the walls. Its stations are used if the observations agree with them.
        algorithm: one of ``ALGORITHMS``.
        cost: measure to minimise: ``"steps"``, ``"seconds"`` or ``"joules"``.
        weight: weight of the heuristic in weighted A*.
        backend: motion backend with which seconds and joules are measured.
        replan: true to make a new plan where a motion leads off the plan.

    Attributes:
        reason: reason of the last action.
        expanded: number of nodes expanded since the last reset.
        plans: number of plans made since the last reset.

    Raises:
        ValueError: the algorithm, the cost or the weight is not allowed.
        TypeError: ``replan`` is neither true nor false.

    Example:
        >>> from agents import SearchAgent
        >>> from warehouse_core import DEFAULT_LAYOUT, WarehouseEnv, record_episode
        >>> agent = SearchAgent(DEFAULT_LAYOUT, algorithm="astar")
        >>> record_episode(WarehouseEnv(), agent, seed=12).steps
        15
    """

    def __init__(
        self,
        layout: Layout,
        algorithm: str = "astar",
        cost: str = STEPS,
        weight: float = WEIGHT,
        backend: Backend = "physics",
        replan: bool = True,
    ) -> None:
        self.layout = instance_of("layout", layout, Layout)
        self.replan = flag("replan", replan)
        self.algorithm = one_of("algorithm", algorithm, ALGORITHMS)
        check_weight(weight)
        self.weight = weight
        self._costs = action_costs(cost, backend)
        self.reset()

    def reset(self) -> None:
        """Forget the plan."""
        self._plan: dict[tuple[Cell, bool], str] = {}
        self._ahead: Iterator[str] = iter(())
        self._before: tuple[Cell, bool] | None = None
        self._is_new = False
        self._knows_stations = True
        self.reason = ""
        self.expanded = self.plans = 0

    def act(self, observation: Observation) -> str:
        """Return the action of the plan for the robot's state."""
        if self.plans and not self.replan:
            return self._go_on()
        state = observation["robot_pos"], observation["has_item"]
        action = self._plan.get(state)
        if action is None:
            return self._make_plan(observation)
        if state == self._before and action in ("PICK", "DROP"):
            # The action had no effect, so there is no station here. Use only the observed stations.
            self._knows_stations = False
            return self._make_plan(observation)
        self._before = state
        if self._is_new:
            self._is_new, self.reason = False, "follows its plan"
        return action

    def _go_on(self) -> str:
        """Return the next action of the first plan, regardless of where the robot is."""
        action = next(self._ahead, None)
        self.reason = "follows its plan" if action else "its plan has ended"
        return action or "WAIT"

    def _make_plan(self, observation: Observation) -> str:
        here, has_item = observation["robot_pos"], observation["has_item"]
        problem = self._problem(observation)
        solution = ALGORITHMS[self.algorithm](problem, self.weight)
        self.plans += 1
        self.expanded += solution.expanded
        if not solution.found:
            self._plan = {(here, has_item): "WAIT"}
            self.reason = f"no path to the {'dropoff' if has_item else 'pickup and dropoff'}"
            return "WAIT"
        # The last state, the delivery, has no action.
        self._plan = {
            ((row, col), loaded): action
            for (row, col, loaded), action in zip(solution.states, solution.actions, strict=False)
        }
        self.reason = "has a plan" if self.plans == 1 else "left its plan, makes a new one"
        self._before, self._is_new = (here, has_item), True
        self._ahead = iter([*self._plan.values()][1:])
        return self._plan[here, has_item]

    def _problem(self, observation: Observation) -> DeliveryProblem:
        """Return the problem of completing the delivery from here."""
        here, has_item = observation["robot_pos"], observation["has_item"]
        stations = [observation["pickup_pos"], observation["dropoff_pos"]]
        own = [self.layout.pickups, self.layout.dropoffs]
        # The layout has all stations, and the observation has the first of each kind. If these
        # differ, the episode has random stations.
        pickups, dropoffs = (
            theirs if self._knows_stations and theirs[:1] == (seen,) else [seen] if seen else []
            for seen, theirs in zip(stations, own, strict=True)
        )
        return DeliveryProblem(
            self.layout, here, has_item, pickups=pickups, dropoffs=dropoffs, costs=self._costs
        )


class ExploringAgent:
    """An agent that knows only its observations, and plans as if all unseen cells were free.

    Whenever it discovers a wall on its path, it makes a new plan, so following a wall of n cells
    can take n searches. If two successive moves fail to reach a cell that it has not seen, it
    assumes a wall there.

    Attributes:
        belief: knowledge and assumptions about the cells.
        reason: reason of the last action.
        expanded: number of nodes expanded since the last reset.
        plans: number of plans made since the last reset.

    Example:
        >>> from agents import ExploringAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), ExploringAgent(), seed=12).steps
        15
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.belief = Belief()
        self.reason = ""
        self.expanded = self.plans = 0
        self._moves: dict[Cell, str] = {}
        self._planned: set[Cell] = set()
        self._goal: Cell | None = None
        self._patience = PATIENCE
        self._left: Cell | None = None
        self._target: Cell | None = None

    def act(self, observation: Observation) -> str:
        """Return the next action of the plan, after making a new plan if the old one is invalid."""
        here, has_item = observation["robot_pos"], observation["has_item"]
        if here == self._left and self._target is not None:
            self.belief.bump(self._target)
        self.belief.look(observation)
        goal = goal_of(observation)
        self._left, self._target = here, None
        if goal is None:
            return self._choose("WAIT", "has no goal")
        if here == goal:
            return self._choose("DROP" if has_item else "PICK", "is at the goal")
        why = self._why_to_plan(here, goal)
        if why:
            self._make_plan(here, goal)
        move = self._moves.get(here)
        if move is None:
            return self._choose("WAIT", f"no path to {goal} around the walls seen so far")
        self._target = moved(here, MOVE_DELTAS[move])
        return self._choose(move, why or "follows its plan")

    @property
    def route(self) -> tuple[Cell, ...]:
        """Cells of the plan, beginning with the cell of the last action."""
        cells = [] if self._left is None else [self._left]
        while cells and cells[-1] in self._moves:
            cells.append(moved(cells[-1], MOVE_DELTAS[self._moves[cells[-1]]]))
        return tuple(cells)

    def _why_to_plan(self, here: Cell, goal: Cell) -> str:
        """Return the reason for making a new plan, or an empty text if the old plan is valid."""
        if goal != self._goal:
            return f"plans a path to {goal}"
        # The plan avoids the walls known before, so only cells seen or hit since then matter.
        new = self._planned.intersection(self.belief.news) | (self._planned & self.belief.bumps)
        if any(not self.belief.is_free(cell) for cell in new):
            return "meets a wall, plans around it"
        if self._moves and here not in self._moves:
            return "left its plan, makes a new one"
        return ""

    def _make_plan(self, here: Cell, goal: Cell) -> None:
        if goal != self._goal:
            self._goal, self._patience = goal, PATIENCE
        solution = self._search(here, goal)
        if not solution.found and self.belief.bumps and self._patience:
            # The moves may have failed for a reason other than a wall.
            self._patience -= 1
            self.belief.forget_bumps()
            solution = self._search(here, goal)
        self._moves = dict(zip(solution.states, solution.actions, strict=False))
        self._planned = set(solution.states)

    def _search(self, here: Cell, goal: Cell) -> Solution[Cell, str]:
        problem = BeliefProblem(self.belief, here, goal)
        solution = astar_search(problem, manhattan(problem))
        self.plans += 1
        self.expanded += solution.expanded
        return solution

    def _choose(self, action: str, reason: str) -> str:
        self.reason = reason
        return action
