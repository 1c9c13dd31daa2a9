"""Lifelong runs: robots that get a new goal whenever they reach theirs."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.errors import PlanError
from agents.mapf.graph import EAST, Graph
from agents.mapf.planner import NO_CELLS, Planner, Situation, next_steps
from warehouse_core.world.tables import Integers

__all__ = ["LifelongRun", "run_lifelong"]

NewGoals = Callable[[Integers, Integers], Integers]
"""Function that returns new goals, ``[R]``, from the cells after a step and the goals so far.

It must not change these arrays.
"""


@dataclass(frozen=True, eq=False)
class LifelongRun:
    """Record of a lifelong run: ``[T + 1, R]`` cells and goals of the robots.

    The seconds, ``[T]``, are processor time of the planner.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> run = run_lifelong(graph, PIBT(graph), robots=8, steps=50, seed=1)
        >>> run.cells.shape, run.reached
        ((51, 8), 48)
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
        """The number of goals that were reached in a step, on average."""
        return self.reached / len(self.seconds)


def run_lifelong(
    graph: Graph,
    planner: Planner,
    robots: int,
    steps: int,
    seed: int,
    starts: Integers | None = None,
    goals: Integers | None = None,
    *,
    has_headings: bool = False,
) -> LifelongRun:
    """Reset a planner and let it lead robots to goals that are drawn anew when they are reached.

    Each robot has random numbers of its own, so that its ``n``-th goal is the same for all
    planners.

    Args:
        graph: floor.
        planner: any planner.
        robots: ``R``.
        steps: ``T``.
        seed: seed of starts and goals.
        starts: cells that starts are drawn from; ``None`` is all open cells.
        goals: cells that goals are drawn from; ``None`` is all open cells.
        has_headings: let robots drive forward and turn, at first heading east.

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

    def new_goals(cells: Integers, wanted: Integers) -> Integers:
        wanted = wanted.copy()
        for robot in np.flatnonzero(cells == wanted).tolist():
            while wanted[robot] == cells[robot]:
                wanted[robot] = streams[robot].choice(goals)
        return wanted

    headings = np.full(robots, EAST) if has_headings else NO_CELLS
    return lead(planner, cells, wanted, new_goals, steps, headings, graph.size)


def lead(
    planner: Planner,
    cells: Integers,
    goals: Integers,
    new_goals: NewGoals,
    steps: int,
    headings: Integers = NO_CELLS,
    size: int = 0,
) -> LifelongRun:
    """Reset a planner and let it lead robots from their first cells to goals that change.

    Where robots have headings, ``size`` is the number of cells, and the planner knows headings.
    """
    nobody = np.zeros(len(cells), np.bool_)
    ways, all_goals, seconds = [cells], [goals], []
    planner.reset()
    for _ in range(steps):
        start = time.process_time()
        situation = Situation(cells, goals, nobody, NO_CELLS)
        cells = next_steps(planner, situation, headings)
        if len(headings):
            headings, cells = np.divmod(cells, size)
        seconds.append(time.process_time() - start)
        goals = new_goals(cells, goals)
        ways.append(cells)
        all_goals.append(goals)
    return LifelongRun(np.array(ways), np.array(all_goals), np.array(seconds))
