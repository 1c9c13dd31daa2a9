"""PIBT: priority inheritance with backtracking.

In each step the robots choose one after the other, in the order of their priorities. A robot that
wants the cell of another gives it its priority: the other chooses next, and if it finds no cell it
stays, and the first tries its next choice. A robot that is at its goal has the lowest priority.

Source: Okumura, Machida, Défago and Tamura (2022), Priority inheritance with backtracking for
iterative multi-agent path finding, Artificial Intelligence 310.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, EAST, FAR, Fields, Graph
from agents.mapf.planner import Situation, solve_by_steps
from agents.mapf.problem import Plan, Problem
from warehouse_core.arguments import instance_of, seed_number
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

NOBODY = -1
UNDECIDED = -1

FREE = -2
"""Next cell of ``NOBODY``."""

WAIT_COST = 1.5
"""Cost of a step in place: without lanes 1.5 more than a move ahead and 0.5 less than one back."""

OCCUPIED_COST, CHANCE_COST = 0.5, 0.2
"""Cost of entering an occupied cell; most that the random tie-break adds.

Together they are less than ``WAIT_COST``, so that no robot waits behind one that it could push.
"""


def choose_cells(
    order: Iterable[int],
    cells: Sequence[int],
    choices: Sequence[Sequence[int]],
    robot_in: Sequence[int],
    is_taken: bytearray,
    chosen: list[int],
    pushers: list[int],
) -> bool:
    """Choose the next cells of all undecided robots, in one round of PIBT.

    The round is a loop with a stack, since chains of thousands of robots that push each other
    would exceed Python's limit on recursion.

    Args:
        order: robots by falling priority.
        cells: ``[R]`` present cells.
        choices: ``[R, 5]`` cells that each robot can go to, the best first.
        robot_in: ``[H * W + 1]`` robot in each cell, or ``NOBODY``.
        is_taken: ``[H * W + 1]`` flags of cells that are closed or chosen; chosen cells are added.
            The last flag is for ``CLOSED`` and is set.
        chosen: ``[R]`` next cells, or ``UNDECIDED``; the choices are written here.
        pushers: ``[R]``, all ``NOBODY``; the robot that made each choose is written here.

    Returns:
        True if each robot has a cell of its own. It is false only if the cell of an undecided
        robot was taken before.
    """
    is_complete = True
    chosen.append(FREE)  # index NOBODY, -1, is the last entry
    for first in order:
        if chosen[first] != UNDECIDED:
            continue
        robot, untried = first, iter(choices[first])
        chain: list[tuple[int, Iterator[int]]] = []  # who waits for the robot that they push
        while True:  # until everybody in the chain has a cell
            here = cells[robot]
            for cell in untried:
                if is_taken[cell]:
                    continue
                other = robot_in[cell]
                there = chosen[other]
                if there == here and other != robot:
                    continue  # they would change places
                chosen[robot] = cell
                is_taken[cell] = True
                if there != UNDECIDED or other == robot:
                    chain.clear()  # the cell will be free, so all who pushed get theirs
                else:
                    pushers[other] = robot
                    chain.append((robot, untried))
                    robot, untried = other, iter(choices[other])
                break
            else:  # nothing is left to try: it stays, and who pushed it tries another cell
                chosen[robot] = here
                pushers[robot] = NOBODY
                is_complete &= bool(chain) or not is_taken[here]
                is_taken[here] = True
                if chain:
                    robot, untried = chain.pop()
                    continue
            if not chain:
                break
    chosen.pop()
    return is_complete


class PIBT:
    """A planner by PIBT.

    The priority of a robot is the number of steps since it was at a goal of its own; urgent robots
    go before all others. Choices that are equally good are ordered by whether somebody is in the
    cell, and then by chance.

    Args:
        graph: floor.
        seed: seed of random tie-breaks.
        turn_cost: cost of a quarter turn in steps. Robots face where they last moved, at first
            east. 0 leaves the graph as it is. For a robot that drives through, a turn costs the
            time to brake, turn and speed up, divided by the time of a cell.

    Attributes:
        fields: distances to the robots' goals.
        pushers: ``[R]`` robot that made each robot choose before its turn in the last step, or
            ``NOBODY``.
    """

    def __init__(self, graph: Graph, seed: int = 0, turn_cost: float = 0.0) -> None:
        self.graph = graph = instance_of("graph", graph, Graph).with_turns(turn_cost)
        self.seed = seed_number(seed)
        costs = np.ones((graph.size, WAIT)) if graph.costs is None else graph.costs
        self._costs = np.pad(costs, ((0, 0), (0, 1)), constant_values=WAIT_COST).astype(np.float32)
        self._costs[graph.neighbours == CLOSED] = np.inf
        self.fields = Fields(graph)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode, and begin again with the random numbers of the seed."""
        self._random = np.random.default_rng(self.seed)
        self._goals: Integers = np.empty(0, np.intp)
        self._cells = self._headings = self._goals
        self.pushers: Integers = np.empty(0, np.intp)

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step, ``[R]``."""
        cells, goals, stays, closed, urgent = situation
        if len(cells) != len(self._goals):
            self._ages, self._goals = np.zeros(len(cells), np.intp), goals
            self._ranks = self._random.random(len(cells))
            self._cells, self._headings = cells, np.full(len(cells), EAST)
        if self.graph.turn_cost:
            self._headings = self.graph.headings(self._cells, cells, self._headings)
            self._cells = cells.copy()
        robot_in = self.robots_in(cells)
        choices, is_there = self.choices(cells, goals, robot_in)
        self._ages = np.where(is_there | (cells == self._goals), 0, self._ages + 1)
        self._goals = goals.copy()
        is_taken = np.zeros(self.graph.size + 1, np.bool_)
        is_taken[closed] = is_taken[cells[stays]] = is_taken[CLOSED] = True
        chosen = np.where(stays, cells, UNDECIDED).tolist()
        priorities = self._ages + self._ranks
        priorities[urgent] += self._ages.max(initial=0) + 1
        order = np.argsort(-priorities).tolist()
        pushers = [NOBODY] * len(cells)
        choose_cells(
            order, cells.tolist(), choices, robot_in.tolist(), bytearray(is_taken), chosen, pushers
        )
        self.pushers = np.array(pushers)
        return np.array(chosen)

    def robots_in(self, cells: Integers) -> Integers:
        """Return the robot in each cell, or ``NOBODY``, ``[H * W + 1]``."""
        robots = np.full(self.graph.size + 1, NOBODY)
        robots[cells] = np.arange(len(cells))
        return robots

    def choices(
        self, cells: Integers, goals: Integers, robot_in: Integers
    ) -> tuple[list[list[int]], NDArray[np.bool_]]:
        """Return the cells that each robot can go to, the best first, and the robots that stay."""
        rows, reached = self.fields.rows(goals), self.graph.neighbours[cells]
        places = self.graph.places_at(cells, self._headings)
        distances = self.fields.matrix[rows[:, None], places]
        costs = distances + self._costs[cells]
        if self.graph.turn_cost:
            costs += self.graph.turns[self._headings]
        costs += OCCUPIED_COST * (robot_in[reached] != NOBODY)
        costs += self._random.random(costs.shape, np.float32) * CHANCE_COST
        is_there = (cells == goals) | (distances[:, WAIT] == FAR)
        costs[is_there, WAIT] = 0
        best = np.argsort(costs, axis=1, kind="stable")
        return np.take_along_axis(reached, best, 1).tolist(), is_there


def pibt(problem: Problem, seconds: float) -> Plan:
    """Return the steps until PIBT has led all robots to their goals at once.

    Raises:
        PlanError: it did not in time; there may be a plan.
    """
    return solve_by_steps(PIBT(problem.graph), problem, seconds)
