"""An entry to the League of Robot Runners: the planner that ``warehouse league`` has by default.

Copy the file into ``python/user_planner`` of the Start-Kit, and name this project in ``pip.txt``.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from agents.mapf.league.entry import errands_of, foreseen, plan_steps
from agents.mapf.league.start_kit import graph_of, steps_of, view_of
from agents.mapf.league.usual import make_usual_planner, usual_graph
from agents.mapf.planner import HeadedPlanner


class pyMAPFPlanner:
    """Plans the next steps of all robots; the Start-Kit sets ``env`` before it calls a method."""

    def __init__(self) -> None:
        self.env: Any = None

    def initialize(self, preprocess_time_limit: int) -> None:
        """Make the planner of the map."""
        self._graph = usual_graph(graph_of(self.env), self.env.num_of_agents)
        self._planner = cache(self._make_planner)
        self._planner(self.env.min_planner_communication_time)

    def plan(self, time_limit: int) -> list[list[int]]:
        """Return the actions of each robot, as numbers of ``MAPF.Action``."""
        view = view_of(self.env, self._graph)
        errands = errands_of(*foreseen(view))
        planner = self._planner(time_limit)
        actions = plan_steps(
            self._graph, planner, view.cells, view.headings, errands, steps_of(self.env)
        )
        return [list(map(int, each)) for each in actions]

    def _make_planner(self, milliseconds: int) -> HeadedPlanner:
        """Return a planner that has so much time for all steps of a plan."""
        seconds = milliseconds / 1000 / steps_of(self.env)
        return make_usual_planner(self._graph, self.env.num_of_agents, seconds)
