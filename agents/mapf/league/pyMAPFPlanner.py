"""An entry to the League of Robot Runners: the planner EPIBT of this project.

Copy the file into ``python/user_planner`` of the Start-Kit, and name this project in ``pip.txt``.
"""

from __future__ import annotations

from typing import Any

from agents.mapf.epibt import EPIBT
from agents.mapf.league.entry import errands_of, foreseen, plan_steps
from agents.mapf.league.start_kit import graph_of, steps_of, view_of


class pyMAPFPlanner:
    """Plans the next steps of all robots; the Start-Kit sets ``env`` before it calls a method."""

    def __init__(self) -> None:
        self.env: Any = None

    def initialize(self, preprocess_time_limit: int) -> None:
        """Make the planner of the map."""
        self._graph = graph_of(self.env)
        self._planner = EPIBT(self._graph)

    def plan(self, time_limit: int) -> list[list[int]]:
        """Return the actions of each robot, as numbers of ``MAPF.Action``."""
        view = view_of(self.env, self._graph)
        errands = errands_of(*foreseen(view))
        actions = plan_steps(
            self._graph, self._planner, view.cells, view.headings, errands, steps_of(self.env)
        )
        return [list(map(int, each)) for each in actions]
