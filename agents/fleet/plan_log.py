"""Log of the plans of chosen robots in each step, for a replay."""

from __future__ import annotations

from collections.abc import Sequence

from agents.mapf.graph import Graph
from agents.mapf.kernels.robots import NOBODY
from agents.mapf.planner import Planner, Situation
from warehouse_core.records.plans import StepPlans
from warehouse_core.world.tables import Integers


class PlanLog:
    """Record of a planner's plans for some robots and, with ``pushes``, of who pushes whom.

    Attributes:
        plans: plans of the steps so far, as ``replay_animation`` takes them.
    """

    def __init__(self, robots: Sequence[int] = (), pushes: bool = False) -> None:
        self.plans: list[StepPlans] = []
        self._robots, self.pushes = robots, pushes

    def add(self, planner: Planner, graph: Graph, situation: Situation, chosen: Integers) -> None:
        """Record the plans of a step from a situation to the chosen cells, ``[R]``.

        ``graph`` is used if the planner has no ``graph`` of its own.
        """
        cells, goals = situation.cells, situation.goals
        graph, plan_of = getattr(planner, "graph", None) or graph, getattr(planner, "plan_of", None)
        paths, wishes = dict[int, list[int]](), dict[int, list[int]]()
        for robot in self._robots:
            ahead = plan_of(robot) if plan_of else []
            # A robot that cannot follow its plan waits.
            is_planned = ahead[:1] == [chosen[robot]]
            paths[robot] = [int(cells[robot]), *(ahead if is_planned else [int(chosen[robot])])]
            wishes[robot] = graph.path(paths[robot][-1], int(goals[robot]))
        places, wished = (
            {robot: graph.layout.cells(path) for robot, path in kind.items()}
            for kind in (paths, wishes)
        )
        pushed = dict[int, int]()
        if self.pushes:
            pushers = getattr(planner, "pushers", ())
            pushed = {robot: int(by) for robot, by in enumerate(pushers) if by != NOBODY}
        self.plans.append(StepPlans(places, wished, pushed))
