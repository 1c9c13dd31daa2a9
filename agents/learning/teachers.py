"""Teachers of a network: they know the right moves in any state that its robots reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

import numpy as np

from agents.learning.map_memory import MOVES
from warehouse_core import Agent, BatchEnv, Layout
from warehouse_core.fleet.observation import observation_of
from warehouse_core.task.encoding import FleetArrays, ObservationArrays
from warehouse_core.world.actions import ACTIONS, action_index
from warehouse_core.world.distances import distances
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import Cell


class Teacher(Protocol):
    """Interface of an expert that labels the right moves for the robots of a batch."""

    def begin(self, rows: Integers, arrays: ObservationArrays) -> None:
        """Prepare for the new episodes of some rows, given the observations of all rows."""

    def moves(self, arrays: ObservationArrays) -> Flags:
        """Return whether each of N, E, S and W is right, ``[B, 4]``; possibly none of them."""


class ShortestPaths:
    """A teacher that knows the map, for which the first move of every shortest path is right.

    A* takes one of these moves, whatever its order of ties.
    """

    def __init__(self, batch: BatchEnv) -> None:
        self._batch, (height, width) = batch, batch.size
        # The border of infinite distances saves tests at the edge of the map.
        self._fields = np.full((batch.num_envs, 2, height + 2, width + 2), np.inf)

    def begin(self, rows: Integers, arrays: ObservationArrays) -> None:
        """Measure the distances to the stations of some rows."""
        layouts = self._batch.layouts
        for number, goals in enumerate((arrays["pickup_pos"], arrays["dropoff_pos"])):
            for row in rows.tolist():
                steps = distances(layouts.kinds[layouts.kind[row]], [_cell(goals[row])])
                height, width = steps.shape
                self._fields[row, number] = np.inf
                self._fields[row, number, 1 : height + 1, 1 : width + 1] = steps

    def moves(self, arrays: ObservationArrays) -> Flags:
        """Return the moves that reduce the distance to the goal."""
        rows, loaded = np.arange(self._batch.num_envs)[:, None], np.asarray(arrays["has_item"])
        neighbours = arrays["robot_pos"][:, None] + MOVES + 1
        near = self._fields[rows, loaded[:, None], neighbours[..., 0], neighbours[..., 1]]
        row, col = arrays["robot_pos"].T + 1
        here = self._fields[rows[:, 0], loaded, row, col]
        nearer: Flags = near < here[:, None]
        return nearer


class AgentTeacher:
    """A teacher for which the action of an agent in each robot's place is right.

    The agents observe all steps of the episodes, but the network acts.

    Args:
        batch: batch of the robots.
        make_agent: function that makes an agent for a layout.
    """

    def __init__(self, batch: BatchEnv, make_agent: Callable[[Layout], Agent]) -> None:
        self._layouts, self._make_agent = batch.layouts, make_agent
        self._agents: list[Agent] = [make_agent(layout) for layout in batch.layouts.rows]

    def begin(self, rows: Integers, arrays: ObservationArrays) -> None:
        """Make new agents for some rows."""
        for row in rows.tolist():
            self._agents[row] = self._make_agent(self._layouts.kinds[self._layouts.kind[row]])
            self._agents[row].reset()

    def moves(self, arrays: ObservationArrays) -> Flags:
        """Return the move of each agent, or none if its action is not a move."""
        chosen = [
            action_index(agent.act(observation_of(cast(FleetArrays, arrays), row)))
            for row, agent in enumerate(self._agents)
        ]
        return np.eye(len(ACTIONS), dtype=np.bool_)[chosen][:, : len(MOVES)]


def _cell(place: Integers) -> Cell:
    return int(place[0]), int(place[1])
