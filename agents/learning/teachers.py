"""Teachers of a network: they say which moves are right wherever its robots have come to."""

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
    """Says what is right for the robots of a batch."""

    def begin(self, rows: Integers, arrays: ObservationArrays) -> None:
        """Prepare for the new episodes of some rows, given what all rows observe."""

    def moves(self, arrays: ObservationArrays) -> Flags:
        """Return which of N, E, S and W are right, ``[B, 4]``; none where no move is."""


class ShortestWays:
    """A teacher that knows the map: each first move of a shortest way to the goal is right.

    So ``A*`` moves, whatever order it breaks ties in.
    """

    def __init__(self, batch: BatchEnv) -> None:
        self._batch, (height, width) = batch, batch.size
        # Nothing is nearer than infinity, so the border needs no tests.
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
        """Return the moves that lead nearer to the goal."""
        rows, loaded = np.arange(self._batch.num_envs)[:, None], np.asarray(arrays["has_item"])
        beside = arrays["robot_pos"][:, None] + MOVES + 1
        near = self._fields[rows, loaded[:, None], beside[..., 0], beside[..., 1]]
        row, col = arrays["robot_pos"].T + 1
        here = self._fields[rows[:, 0], loaded, row, col]
        nearer: Flags = near < here[:, None]
        return nearer


class AgentTeacher:
    """A teacher that asks an agent for each robot: what it would do there is right.

    The agents observe all steps of the episodes, but it is the network that acts.

    Args:
        batch: batch of the robots.
        make_agent: function that makes an agent, given a layout.
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
        """Return the move of each agent, none if it does something else."""
        chosen = [
            action_index(agent.act(observation_of(cast(FleetArrays, arrays), row)))
            for row, agent in enumerate(self._agents)
        ]
        return np.eye(len(ACTIONS), dtype=np.bool_)[chosen][:, : len(MOVES)]


def _cell(place: Integers) -> Cell:
    return int(place[0]), int(place[1])
