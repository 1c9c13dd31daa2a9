"""Time of a step of EPIBT for robots with headings against PIBT for robots without, 10,000 each."""

import time
from collections.abc import Callable

import numpy as np
from helpers.fleet_truth import big_warehouse

from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.planner import NO_CELLS, Situation

ROBOTS, GOALS, STEPS, WARM_UP = 10_000, 500, 60, 5
"""Robots share some goals, whose distances are all known after the first step."""

MOST = 3.0
"""Most times that a step with headings takes the time of one without."""

Step = Callable[[Situation], np.ndarray]


class Fleet:
    """Robots that go from goal to goal.

    Args:
        step: chooses the next cell of each robot.
        cells: ``[R]``, cells of the robots at first.
        goals: cells in which they have their goals.
    """

    def __init__(self, step: Step, cells: np.ndarray, goals: np.ndarray) -> None:
        self.step, self.cells, self.ends = step, cells, goals
        self.stream, self.reached = np.random.default_rng(1), 0
        self.goals = self.stream.choice(goals, len(cells))

    def seconds(self) -> float:
        """Take a step, and return the processor time of the planner."""
        situation = Situation(self.cells, self.goals, np.zeros(ROBOTS, np.bool_), NO_CELLS)
        start = time.process_time()
        self.cells = self.step(situation)
        seconds = time.process_time() - start
        is_there = self.cells == self.goals
        self.reached += int(is_there.sum())
        self.goals = np.where(is_there, self.stream.choice(self.ends, ROBOTS), self.goals)
        return seconds


def test_headings_take_at_most_three_times_the_time(measured) -> None:
    graph = Graph(big_warehouse())
    cells = np.random.default_rng(0).permutation(graph.layout.open_cells)
    turning, headings = EPIBT(graph), np.ones(ROBOTS, np.intp)

    def turn(situation: Situation) -> np.ndarray:
        headings[:], cells = np.divmod(turning.next_places(situation, headings), graph.size)
        return cells

    steps: list[Step] = [turn, PIBT(graph).next_cells]
    fleets = [Fleet(step, cells[:ROBOTS], cells[-GOALS:]) for step in steps]
    times = np.array([[fleet.seconds() for fleet in fleets] for _ in range(STEPS)])[WARM_UP:]
    with_headings, without = np.median(times, axis=0)
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    measured(
        f"a step of {ROBOTS:,} robots with headings by EPIBT, and without by PIBT, 140 x 500 cells",
        f"{1000 * with_headings:.0f} and {1000 * without:.0f} ms of CPU time, ratio {ratio:.2f}; "
        f"{fleets[0].reached:,} and {fleets[1].reached:,} goals in {STEPS} steps",
    )
    assert ratio < MOST
