"""LaCAM: lazy constraints addition search, complete, with PIBT as generator of configurations.

The search is depth-first over configurations, the cells of all robots at once. Each has a tree of
constraints, who must go where next, that grows by a robot when the search comes back to it; PIBT
chooses the cells of the others. When all trees are used up, there is no plan.

Source: Okumura (2023), LaCAM: search-based algorithm for quick multi-agent pathfinding, AAAI; the
swaps are of Okumura (2023), Improving LaCAM for scalable eventually optimal multi-agent
pathfinding, IJCAI.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import CLOSED, Graph
from agents.mapf.pibt import NOBODY, PIBT, UNDECIDED, choose_cells
from agents.mapf.problem import Plan, Problem
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

FixedMoves = tuple[tuple[int, int], ...]
"""Robots and their next cells."""


@dataclass(eq=False)
class Configuration:
    """A configuration: ``[R]`` cells, and ``[R]`` steps since each robot was at its goal.

    The robots are in the order of falling priority, and ``tree`` has the constraints that were not
    yet tried. The first configuration has no parent.
    """

    cells: Integers
    ages: Integers
    order: list[int]
    parent: Configuration | None
    tree: deque[FixedMoves]


def lacam(problem: Problem, seconds: float, seed: int = 0) -> Plan:
    """Return a plan, which need not be optimal.

    Raises:
        PlanError: there is none, or none was found in time.
    """
    return _Search(problem, seed).run(seconds)


class Swaps:
    """The choices of robots that must change places in a narrow way, which PIBT alone cannot do.

    A robot that is to swap with the one ahead backs off instead, as far as to where two ways lead
    on; the other follows.
    """

    def __init__(self, graph: Graph, goals: Sequence[int]) -> None:
        beside = graph.neighbours[:, :WAIT]
        self.beside = [[cell for cell in row if cell != CLOSED] for row in beside.tolist()]
        self.goals = goals
        self.fields = [graph.distances(goal) for goal in goals]

    def reverse(self, cells: list[int], choices: list[list[int]], robot_in: list[int]) -> None:
        """Reverse the choices of the robots that have to back off."""
        for robot, cell in enumerate(cells):
            ahead = choices[robot][0]
            if ahead != cell and self.must_back_off(robot, cell, ahead, robot_in):
                count = len(self.beside[cell]) + 1
                choices[robot][:count] = choices[robot][:count][::-1]

    def must_back_off(self, robot: int, cell: int, ahead: int, robot_in: list[int]) -> bool:
        """Return whether a robot has to let one pass that is ahead of it, or follows it."""
        if robot_in[ahead] != NOBODY:
            pairs = [(robot, robot_in[ahead])]
        else:
            behind = [robot_in[other] for other in self.beside[cell]]
            pairs = [(other, robot) for other in behind if other != NOBODY]
        return any(
            self.is_required(*pair, cell, ahead, robot_in) for pair in pairs
        ) and self.is_possible(ahead, cell, robot_in)

    def is_required(
        self, pusher: int, puller: int, behind: int, ahead: int, robot_in: list[int]
    ) -> bool:
        """Return whether two have to change places: pushing on leads nowhere."""
        near, far = self.fields[pusher], self.fields[puller]
        while near[ahead] < near[behind]:
            exits = self.exits(ahead, behind, robot_in)
            if len(exits) > 1:
                return False
            if not exits:
                break
            behind, ahead = ahead, exits[0]
        return bool(far[behind] < far[ahead] and (near[behind] == 0 or near[ahead] < near[behind]))

    def is_possible(self, behind: int, ahead: int, robot_in: list[int]) -> bool:
        """Return whether the way from ``behind`` by ``ahead`` leads to where two ways lead on."""
        start = behind
        while ahead != start:
            exits = self.exits(ahead, behind, robot_in)
            if len(exits) != 1:
                return len(exits) > 1
            behind, ahead = ahead, exits[0]
        return False

    def exits(self, cell: int, behind: int, robot_in: list[int]) -> list[int]:
        """Return the other ways on from a cell, without dead ends in which a robot has its goal."""
        return [
            other
            for other in self.beside[cell]
            if other != behind
            and not (
                len(self.beside[other]) == 1
                and robot_in[other] != NOBODY
                and self.goals[robot_in[other]] == other
            )
        ]


class _Search:
    def __init__(self, problem: Problem, seed: int) -> None:
        self.graph, self.goals = problem.graph, np.array(problem.goals)
        self.pibt = PIBT(problem.graph, seed)
        self.random = np.random.default_rng(seed)
        self.swaps = Swaps(self.graph, problem.goals)
        self.ranks = self.random.random(problem.robots)
        self.start = self.new_node(np.array(problem.starts), None)

    def run(self, seconds: float) -> Plan:
        """Search depth-first."""
        deadline = time.perf_counter() + seconds
        explored, opened = {self.start.cells.tobytes(): self.start}, [self.start]
        while opened:
            if time.perf_counter() > deadline:
                raise PlanError(
                    f"LaCAM found no plan in {seconds} s; it saw {len(explored)} configurations"
                )
            node = opened[-1]
            if (node.cells == self.goals).all():
                return _plan_to(node)
            if not node.tree:
                opened.pop()
                continue
            constraint = node.tree.popleft()
            self.grow(node, constraint)
            cells = self.next_cells(node, constraint)
            if cells is not None:
                key = cells.tobytes()
                if key not in explored:
                    explored[key] = self.new_node(cells, node)
                    opened.append(explored[key])
        raise PlanError(f"there is no plan: LaCAM tried all {len(explored)} configurations")

    def new_node(self, cells: Integers, parent: Configuration | None) -> Configuration:
        """Return a node with an empty constraint."""
        ages = 0 if parent is None else parent.ages + 1
        ages = np.where(cells == self.goals, 0, ages)
        order = np.argsort(-ages - self.ranks).tolist()
        return Configuration(cells, ages, order, parent, deque([()]))

    def grow(self, node: Configuration, constraint: FixedMoves) -> None:
        """Add the constraints that also say where the next robot must go."""
        if len(constraint) < len(node.order):
            robot = node.order[len(constraint)]
            reached = self.graph.neighbours[node.cells[robot]]
            for cell in self.random.permutation(reached[reached != CLOSED]).tolist():
                node.tree.append((*constraint, (robot, cell)))

    def next_cells(self, node: Configuration, constraint: FixedMoves) -> Integers | None:
        """Return the next configuration, or ``None`` if PIBT finds none."""
        robots = self.pibt.robots_in(node.cells)
        cells, robot_in = node.cells.tolist(), robots.tolist()
        chosen, pushers = [UNDECIDED] * len(cells), [NOBODY] * len(cells)
        is_taken = bytearray(len(robot_in))
        is_taken[CLOSED] = True
        for robot, cell in constraint:
            other = robot_in[cell]
            swaps = other not in (NOBODY, robot) and chosen[other] == cells[robot]
            if is_taken[cell] or swaps:
                return None
            chosen[robot], is_taken[cell] = cell, True
        choices, _ = self.pibt.choices(node.cells, self.goals, robots)
        self.swaps.reverse(cells, choices, robot_in)
        is_complete = choose_cells(node.order, cells, choices, robot_in, is_taken, chosen, pushers)
        return np.array(chosen) if is_complete else None


def _plan_to(node: Configuration | None) -> Plan:
    cells = []
    while node is not None:
        cells.append(node.cells)
        node = node.parent
    return Plan(np.array(cells[::-1]))
