"""What the Start-Kit of the League shows its entries in Python, as a view of this project.

Source: ``Python_Interface.md`` of the League's Start-Kit, 3.1.0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.mapf.graph import Graph
from agents.mapf.league.entry import View
from agents.mapf.league.executor import way_of
from agents.mapf.league.tasks import LeagueTask
from warehouse_core import Layout

EAST, HEADINGS = 1, 4
"""Heading of a robot whose orientation is 0; number of headings."""


def graph_of(env: Any) -> Graph:
    """Return the floor of an environment of the Start-Kit."""
    tiles = "".join(".#"[tile] for tile in env.map)
    rows = [tiles[start : start + env.cols] for start in range(0, len(tiles), env.cols)]
    return Graph(Layout(rows))


def view_of(env: Any, graph: Graph) -> View:
    """Return the view of an environment of the Start-Kit, whose tasks are known by number."""
    known = {}
    for number in env.task_pool:
        task = env.task_pool[number]
        cells = tuple(task.locations)
        known[number] = LeagueTask(
            number, cells, task.t_revealed, task.idx_next_loc, task.agent_assigned
        )
    ahead = graph.neighbours.tolist()
    passed = [
        way_of(ahead, state.location, heading_of(state), map(int, actions))
        for state, actions in zip(env.system_states, env.staged_actions, strict=True)
    ]
    return View(
        env.system_timestep,
        np.array([state.location for state in env.curr_states]),
        np.array([heading_of(state) for state in env.curr_states]),
        known,
        np.array(env.curr_task_schedule),
        passed,
    )


def heading_of(state: Any) -> int:
    """Return the heading of a robot in a state of the Start-Kit."""
    return int(state.orientation + EAST) % HEADINGS


def steps_of(env: Any) -> int:
    """Return the steps that robots can carry out until the next plan, and one more."""
    return int(env.min_planner_communication_time // (env.action_time * env.max_counter)) + 1
