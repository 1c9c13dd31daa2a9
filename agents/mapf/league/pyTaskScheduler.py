"""An entry to the League of Robot Runners: the scheduler of this project.

Copy the file into ``python/user_scheduler`` of the Start-Kit, and name this project in ``pip.txt``.
"""

from __future__ import annotations

from typing import Any

from agents.mapf.league.entry import assigned
from agents.mapf.league.scheduler import Scheduler
from agents.mapf.league.start_kit import graph_of, view_of
from agents.mapf.league.usual import usual_graph


class pyTaskScheduler:
    """Gives tasks to robots; the Start-Kit sets ``env`` before it calls a method."""

    def __init__(self) -> None:
        self.env: Any = None
        self._scheduler: Scheduler | None = None

    def initialize(self, preprocess_time_limit: int) -> None:
        """Read the map, and find the costs of the planner's moves."""
        self._graph = usual_graph(graph_of(self.env), self.env.num_of_agents)

    def plan(self, time_limit: int) -> list[int]:
        """Return the task of each robot, or -1."""
        view = view_of(self.env, self._graph)
        if self._scheduler is None:
            self._scheduler = Scheduler(self._graph, len(view.known))
        _, _, schedule = assigned(view, self._scheduler)
        return list(map(int, schedule))
