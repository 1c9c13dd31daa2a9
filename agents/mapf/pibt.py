"""PIBT, priority inheritance with backtracking, with swaps; see ``kernels/pibt.py``."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Fields, Graph, robots_in
from agents.mapf.kernels.buffers import IS_COMPILED, buffer_of, prepare
from agents.mapf.kernels.pibt import (
    CHANCE_KEY,
    CHOSEN,
    CLOSED,
    OCCUPIED_KEY,
    STEP_KEY,
    WAIT_KEY,
    choose,
    pibt_of,
)
from agents.mapf.kernels.places import FAR, STAY
from agents.mapf.kernels.robots import NOBODY, SPREAD, UNDECIDED, draw, mix, robots_of
from agents.mapf.memory import Memory
from agents.mapf.planner import PlacePlanner, Situation, solve_by_steps
from agents.mapf.problem import Plan, Problem
from warehouse_core.arguments import instance_of, seed_number
from warehouse_core.world.tables import Integers

__all__ = ["PIBT", "pibt"]


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
        """Begin an episode of the given number of robots."""
        self._memory = Memory(self.graph, np.random.default_rng(self.seed).random(robots))
        self._robots = robots_of(self.graph.size, robots, self.seed)
        self._pibt = pibt_of(self.graph.size, robots)

    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        """Return the next place of each robot."""
        cells, goals, stays, closed, urgent = situation
        places = self._memory.places(cells)
        order = self._memory.order(cells, goals, urgent)
        is_taken = np.zeros(self.graph.size, np.int64)
        is_taken[closed] = CLOSED
        is_taken[cells[stays]] = CHOSEN
        robot_in = robots_in(self.graph.size, cells)
        rows = self.fields.rows(goals)
        robots, pibt = self._robots, self._pibt
        for kept, new in (
            (robots.places, places), (robots.goals, goals), (robots.rows, rows * self.graph.places),
            (robots.order, order), (pibt.pushers, np.full(len(cells), NOBODY)),
            (robots.chosen, np.where(stays, places, UNDECIDED)), (robots.robot_in, robot_in),
            (pibt.is_taken, is_taken),
        ):  # fmt: skip
            kept[:] = buffer_of(new)
        if not IS_COMPILED:
            near = self.fields.near[places]
            self._sort_choices(near, self._keys(rows, places, goals, robot_in))
        choose(self.fields.floor, robots, pibt, self.fields.table)
        self.pushers = np.array(pibt.pushers)
        return np.array(robots.chosen)

    def _keys(
        self, rows: Integers, places: Integers, goals: Integers, robot_in: Integers
    ) -> NDArray[Any]:
        """Return the keys of the choices of all robots, ``[R, 5]``; low keys are tried first.

        They equal the keys in ``kernels.pibt.sort_choices``. With more than a few robots, NumPy is
        faster than plain Python.
        """
        near = self.fields.near[places]
        is_step, number = near != self.graph.places, np.arange(len(places), dtype=np.int64)
        to = np.where(is_step, near, places[:, None])
        draw(self._robots.random)
        chance = cast(Integers, mix(cast(int, self._robots.random[0] + number * SPREAD)))[:, None]
        chance = chance >> 3 * (is_step.cumsum(axis=1) - 1) & CHANCE_KEY
        distances = self.fields.matrix[rows[:, None], to].astype(np.int64)
        keys: Integers = (distances + self.fields.prices[places]) * (
            STEP_KEY // self.fields.step
        ) + chance
        keys += OCCUPIED_KEY * (robot_in[to % self.graph.size] != NOBODY)
        keys[:, STAY] += WAIT_KEY - OCCUPIED_KEY
        keys[(places % self.graph.size == goals) | (distances[:, STAY] == FAR), STAY] = 0
        keys[~is_step] = np.iinfo(np.int64).max
        return keys

    def _sort_choices(self, near: Integers, keys: NDArray[Any]) -> None:
        """Sort the choices of all robots by their keys; closed cells have the highest key."""
        pibt, best = self._pibt, np.argsort(keys, axis=1, kind="stable")
        pibt.choices[:] = buffer_of(np.take_along_axis(near, best, 1))
        pibt.options[:] = buffer_of((near != self.graph.places).sum(axis=1))
        pibt.is_sorted[0] = 1


def pibt(problem: Problem, seconds: float, seed: int = 0) -> Plan:
    """Return the plan that results when PIBT moves all robots until all are at their goals.

    Raises:
        PlanError: this did not happen in time, although a plan may exist.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.pibt import pibt
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> pibt(problem, seconds=10).makespan
        5
    """
    return solve_by_steps(PIBT(problem.graph, seed), problem, seconds)
