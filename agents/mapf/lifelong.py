"""Lifelong runs, in which each robot gets a new goal whenever it reaches the current one."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.errors import PlanError
from agents.mapf.graph import EAST, Graph
from agents.mapf.planner import NO_CELLS, Planner, Situation, next_steps
from warehouse_core.world.tables import Integers

__all__ = ["run_lifelong"]


@dataclass(frozen=True, eq=False)
class LifelongRun:
    """Record of a lifelong run: the cells and goals of the robots, each ``[T + 1, R]``.

    The array ``seconds``, ``[T]``, has the processor time of the planner in each step.
    """

    cells: Integers
    goals: Integers
    seconds: NDArray[np.float64]

    @property
    def reached(self) -> int:
        """The number of goals that were reached."""
        return int((self.cells[1:] == self.goals[:-1]).sum())

    @property
    def throughput(self) -> float:
        """The mean number of goals that were reached in a step."""
        return self.reached / len(self.seconds)


def run_lifelong(
    graph: Graph, planner: Planner, robots: int, steps: int, seed: int,
    starts: Integers | None = None, goals: Integers | None = None, *, has_headings: bool = False,
) -> LifelongRun:  # fmt: skip
    """Run a planner with random goals, each of which is replaced when a robot reaches it.

    Each robot has a random number stream of its own, so that its ``n``-th goal is the same for all
    planners.

    Args:
        graph: floor.
        planner: any planner; it is reset first.
        robots: ``R``.
        steps: ``T``.
        seed: seed of starts and goals.
        starts: cells from which the starts are sampled; ``None`` is all open cells.
        goals: cells from which the goals are sampled; ``None`` is all open cells.
        has_headings: true if robots drive forward and turn, initially heading east.

    Raises:
        PlanError: there are fewer cells to start from than robots, or fewer than two goals.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> run_lifelong(graph, PIBT(graph), robots=8, steps=50, seed=1).throughput
        0.96
    """
    open_cells = graph.layout.open_cells
    starts = open_cells if starts is None else starts
    goals = open_cells if goals is None else goals
    if not 0 < robots <= len(starts):
        raise PlanError(f"{robots} robots; allowed: 1 to {len(starts)}, the cells to start from")
    if len(goals) < 2:
        raise PlanError("a lifelong run needs at least two goals")
    streams = np.random.default_rng(seed).spawn(robots + 1)
    cells = streams[-1].permutation(starts)[:robots]
    wanted = np.array([stream.choice(goals) for stream in streams[:robots]])

    headings = np.full(robots, EAST) if has_headings else NO_CELLS
    nobody = np.zeros(robots, np.bool_)
    all_cells, all_goals, seconds = [cells], [wanted], []
    planner.reset()
    for _ in range(steps):
        start = time.process_time()
        situation = Situation(cells, wanted, nobody, NO_CELLS)
        cells = next_steps(planner, situation, headings)
        if len(headings):
            headings, cells = np.divmod(cells, graph.size)
        seconds.append(time.process_time() - start)
        wanted = wanted.copy()
        for robot in np.flatnonzero(cells == wanted).tolist():
            while wanted[robot] == cells[robot]:
                wanted[robot] = streams[robot].choice(goals)
        all_cells.append(cells)
        all_goals.append(wanted)
    return LifelongRun(np.array(all_cells), np.array(all_goals), np.array(seconds))
