"""Carries out plans of several steps in the order of the plan, whatever is delayed.

Each cell has a queue: the robot in it, then those that the plan leads into it, in turn. A robot
enters a cell when it is first in the queue, so when all before it have left the cell for good. No
two robots ever touch, if they are not larger than a cell. What of a plan would wait in a circle, as
where robots rotate, is dropped, so that nobody waits for ever. ``R`` is the number of robots.

Source: Ma, Kumar and Koenig (2017), Multi-agent path finding with delay probabilities, AAAI, for
queues of cells; ``src/Simulator.cpp`` of the League's Start-Kit, 3.1.0, for staged actions.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Graph
from agents.mapf.league.rules import WAITING
from warehouse_core.world.moves import FORWARD, HEADING_AFTER
from warehouse_core.world.tables import Integers

Queues = dict[int, deque[int]]


class Executor:
    """Robots with staged actions, which take several ticks each.

    Args:
        graph: floor.
        cells: ``[R]``, cells of the robots, all different.
        headings: ``[R]``, their headings.
        ticks: ticks of a move or a turn.

    Attributes:
        cells, headings: where the robots are; a robot is in its old cell until it has arrived.
        staged: staged actions of each robot.
        ends, end_headings: where they are once they have carried out what is staged.
    """

    def __init__(self, graph: Graph, cells: Integers, headings: Integers, ticks: int) -> None:
        self._ahead: list[list[int]] = graph.neighbours.tolist()
        self._ticks = ticks
        self.cells, self.headings = cells.tolist(), headings.tolist()
        self.ends, self.end_headings = list(self.cells), list(self.headings)
        self.staged = [deque[int]() for _ in self.cells]
        self._count = [0] * len(self.cells)
        self._queues: Queues = defaultdict(deque)
        for robot, cell in enumerate(self.cells):
            self._queues[cell].append(robot)

    @property
    def passed(self) -> list[list[int]]:
        """``[R]`` lists of the cells that robots are in after the next tick and later, in turn."""
        found = []
        for robot, staged in enumerate(self.staged):
            leaves = staged and staged[0] == FORWARD and self._count[robot] == self._ticks - 1
            way = way_of(self._ahead, self.cells[robot], self.headings[robot], staged)
            found.append(way[bool(leaves) :])
        return found

    def stage(self, actions: Integers) -> None:
        """Append a plan, ``[R, steps]`` actions that begin at ``ends``, to the staged actions.

        What cannot be carried out, one action a step, within as many steps, is dropped.
        """
        cells, headings = list(self.ends), list(self.end_headings)
        for column in actions.T.tolist():
            for robot, action in enumerate(column):
                if action == WAITING:
                    continue
                self.staged[robot].append(action)
                if action == FORWARD:
                    cells[robot] = self._ahead[cells[robot]][headings[robot]]
                    self._queues[cells[robot]].append(robot)
                headings[robot] = int(HEADING_AFTER[headings[robot], action])
        self._keep_possible(actions.shape[1])

    def _keep_possible(self, steps: int) -> None:
        """Drop the staged actions that robots cannot carry out in so many steps."""
        cells, headings = list(self.cells), list(self.headings)
        done = [0] * len(cells)
        queues: Queues = defaultdict(deque)
        for robot, cell in enumerate(cells):
            queues[cell].append(robot)
        for _ in range(steps):
            waiting, progress = list(range(len(cells))), True
            while progress:
                blocked, progress = [], False
                for robot in waiting:
                    if done[robot] == len(self.staged[robot]):
                        continue
                    action = self.staged[robot][done[robot]]
                    if action == FORWARD:
                        to = self._ahead[cells[robot]][headings[robot]]
                        if self._queues[to][0] != robot:
                            blocked.append(robot)
                            continue
                        self._queues[cells[robot]].popleft()
                        cells[robot] = to
                        queues[to].append(robot)
                    headings[robot] = int(HEADING_AFTER[headings[robot], action])
                    done[robot] += 1
                    progress = True
                waiting = blocked
        for robot, staged in enumerate(self.staged):
            while len(staged) > done[robot]:
                staged.pop()
        self._queues, self.ends, self.end_headings = queues, cells, headings

    def tick(self, is_delayed: NDArray[np.bool_]) -> Integers:
        """Let a tick pass and return the action of each robot, ``[R]``; delayed robots wait."""
        actions = np.full(len(self.cells), WAITING)
        for robot in np.flatnonzero(~is_delayed).tolist():
            action = self.staged[robot][0] if self.staged[robot] else WAITING
            if action != WAITING and (action != FORWARD or self._may_enter(robot)):
                actions[robot] = action
        for robot in np.flatnonzero(actions != WAITING).tolist():
            self._count[robot] += 1
            if self._count[robot] == self._ticks:
                self._complete(robot)
        return actions

    def _may_enter(self, robot: int) -> bool:
        """Return whether a robot is first in the queue of the cell ahead."""
        ahead = self._ahead[self.cells[robot]][self.headings[robot]]
        return self._queues[ahead][0] == robot

    def _complete(self, robot: int) -> None:
        """Complete the first staged action of a robot."""
        action, self._count[robot] = self.staged[robot].popleft(), 0
        if action == FORWARD:
            here = self.cells[robot]
            self.cells[robot] = self._ahead[here][self.headings[robot]]
            self._queues[here].popleft()
        self.headings[robot] = int(HEADING_AFTER[self.headings[robot], action])


def way_of(
    ahead: Sequence[Sequence[int]], cell: int, heading: int, actions: Iterable[int]
) -> list[int]:
    """Return the cells of a robot before its actions and after each move.

    Args:
        ahead: cell ahead of a robot in each cell, by heading.
        cell: cell of the robot.
        heading: heading of the robot.
        actions: actions of the robot.
    """
    way = [cell]
    for action in actions:
        if action == FORWARD:
            way.append(ahead[way[-1]][heading])
        heading = int(HEADING_AFTER[heading, action])
    return way
