"""PIBT, priority inheritance with backtracking, with swaps; see ``kernels/pibt.py``."""

from __future__ import annotations

import numpy as np

from agents.mapf.graph import CLOSED, Fields, Graph, robots_in
from agents.mapf.kernels.buffers import write
from agents.mapf.kernels.pibt import CHANCE_KEY, STEP_KEY, WAIT_KEY, choose, pibt_of
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, robots_of
from agents.mapf.planner import Memory, PlacePlanner, Situation
from warehouse_core.arguments import instance_of, seed_number
from warehouse_core.compiled import prepare
from warehouse_core.world.tables import Integers

__all__ = ["PIBT"]


class PIBT(PlacePlanner):
    """Planner that moves robots with PIBT.

    The priority of a robot is the number of steps since it was at a goal of its own. Urgent robots
    go before all others. Choices that are equally near the goal are ordered by whether a robot is
    in the cell, and then at random.

    Args:
        graph: floor.
        seed: seed of random tie-breaks.
        turn_cost: cost of a quarter turn in steps. Robots face where they last moved, and east at
            first. With 0 the graph is used as it is. For a robot that drives through, a turn costs
            the time to brake, turn and speed up, divided by the time for a cell.

    Attributes:
        pushers: ``[R]``, robot that made each robot choose before its turn in the last step, or
            ``NOBODY``.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> run_lifelong(graph, PIBT(graph), robots=8, steps=50, seed=1).throughput
        0.96
    """

    knows_headings = False

    def __init__(self, graph: Graph, seed: int = 0, turn_cost: float = 0.0) -> None:
        self.graph = graph = instance_of("graph", graph, Graph).with_turns(turn_cost)
        self.seed = seed_number(seed)
        self.fields = Fields(graph)
        prepare(choose)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode, and restart the random numbers from the seed."""
        super().reset()
        self.pushers = np.empty(0, np.intp)

    def _begin(self, robots: int, has_headings: bool) -> None:
        self._memory = Memory(self.graph, np.random.default_rng(self.seed).random(robots))
        self._robots = robots_of(self.graph.size, robots, self.seed)
        self._pibt = pibt_of(self.graph.size, robots)

    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        cells, goals, stays, closed, urgent, _ = situation
        places = self._memory.places(cells)
        order = self._memory.order(cells, goals, urgent)
        robots, pibt = self._robots, self._pibt
        write(
            robots, places=places, goals=goals, rows=self.fields.rows(goals) * self.graph.places,
            order=order, chosen=np.where(stays, places, UNDECIDED),
            robot_in=robots_in(self.graph.size, cells), is_closed=self.graph.closed_with(closed),
        )  # fmt: skip
        write(pibt, pushers=np.full(len(cells), NOBODY))
        choose(self.fields.floor, robots, pibt, self.fields.table)
        self.pushers = np.array(pibt.pushers)
        return np.array(robots.chosen)


class PlainPIBT:
    """A step of PIBT in the words of the paper, for reading; robots have no headings.

    Each robot chooses a cell by priority. If a robot of lower priority is there, it inherits the
    priority and chooses next. If it finds no cell, it stays, and the first robot tries another cell
    (backtracking). The kernel of the planner chooses the same cells, and lets robots swap in
    corridors. See ``kernels/pibt.py``.

    Args:
        graph: floor; its costs are not used.
        cells: cell of each robot, all different.
        goals: goal of each robot.
        bits: random bits of each robot, three for each direction, which break ties.

    Source: Okumura, Machida, Défago and Tamura (2022), Priority inheritance with backtracking for
    iterative multi-agent path finding, Artificial Intelligence 310, algorithm 1.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.pibt import PlainPIBT
        >>> from warehouse_core import Layout
        >>> graph = Graph(Layout(["...", "..."]))
        >>> PlainPIBT(graph, cells=[0, 1], goals=[2, 1], bits=[0, 0]).step([0, 1])
        [1, 2]
    """

    def __init__(self, graph: Graph, cells: list[int], goals: list[int], bits: list[int]) -> None:
        self.graph, self.cells, self.goals, self.bits = graph, cells, goals, bits
        self.robot_in = {cell: robot for robot, cell in enumerate(cells)}
        self.next: dict[int, int] = {}
        self.taken: set[int] = set()

    def step(self, order: list[int]) -> list[int]:
        """Return the next cell of each robot; ``order`` has the robots by decreasing priority."""
        for robot in order:
            if robot not in self.next:
                self.finds_cell(robot)
        return [self.next[robot] for robot in range(len(self.cells))]

    def finds_cell(self, robot: int) -> bool:
        """Choose the next cell of a robot, and return false if it has to stay for lack of one."""
        here = self.cells[robot]
        for cell in self.candidates(robot):
            other = self.robot_in.get(cell, NOBODY)
            if cell in self.taken or (other != robot and self.next.get(other, cell) == here):
                continue  # two robots would be in one cell, or swap cells
            self.next[robot] = cell
            self.taken.add(cell)
            if other == NOBODY or other in self.next or self.finds_cell(other):
                return True
        self.next[robot] = here
        self.taken.add(here)
        return False

    def candidates(self, robot: int) -> list[int]:
        """Return the neighbours of a robot's cell and the cell itself, nearest to the goal first.

        A robot in a cell counts as half a step, and so does waiting. Chance breaks ties.
        """
        here, goal, bits, keys = self.cells[robot], self.goals[robot], self.bits[robot], {}
        distances = self.graph.distances(goal)
        for cell in self.graph.neighbours[here].tolist():
            if cell != CLOSED:
                penalty = WAIT_KEY if cell == here or cell in self.robot_in else 0
                keys[cell] = STEP_KEY * distances[cell] + penalty + (bits & CHANCE_KEY)
                bits >>= 3
        if here == goal:
            keys[here] = -1
        return sorted(keys, key=keys.__getitem__)
