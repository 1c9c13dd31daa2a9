"""Robots that turn on the spot: what it is worth that planners count turns.

``WAREHOUSE_PLANS`` is the number of plans of each planner and number of robots.
"""

import os
from typing import NamedTuple

import numpy as np
import pytest

from agents.mapf.execution import drive_through
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.registry import make_planner
from warehouse_core.world.generators import kiva_warehouse
from warehouse_physics import RobotSpec

PLANS, STEPS = int(os.environ.get("WAREHOUSE_PLANS", "1")), 100
SPEC = RobotSpec(turn_seconds=1.5)

TURN_COST = (SPEC.turn_seconds + SPEC.top_speed / SPEC.acceleration) * SPEC.top_speed
"""In cells at top speed: a turn, and braking and speeding up for it."""

LAYOUT, STARTS, GOALS = kiva_warehouse()
MIN_GAIN = {"pibt": 1.15, "windowed": 1.15, "windowed-lanes": 0.9}
"""Goals an hour with costs of turns over those without."""


class Found(NamedTuple):
    """Goals an hour, corners of a robot in 100 moves, and joules a goal of plans driven through."""

    goals: float
    corners: float
    joules: float


def drive(planner: str, robots: int) -> Found:
    """Let robots that turn drive through plans."""
    reached, seconds, joules, corners, moves = 0, 0.0, 0.0, 0, 0
    for seed in range(PLANS):
        made = make_planner(planner, seed, LAYOUT, robots)
        run = run_lifelong(Graph(LAYOUT), made, robots, STEPS, seed, STARTS, GOALS)
        execution = drive_through(LAYOUT, run.cells, SPEC)
        assert execution.hits == 0
        reached += run.reached
        seconds += execution.seconds
        joules += execution.joules
        for steps in np.diff(run.cells.astype(int), axis=0).T:
            steps = steps[steps != 0]
            corners += int((np.diff(steps) != 0).sum())
            moves += len(steps)
    return Found(3600 * reached / seconds, 100 * corners / moves, joules / reached)


@pytest.mark.parametrize("robots", [32, 100])
@pytest.mark.parametrize("planner", MIN_GAIN)
def test_planners_that_count_turns_reach_more_goals(planner, robots, measured) -> None:
    plain, counting = drive(planner, robots), drive(f"{planner}:turn_cost={TURN_COST}", robots)
    gain = counting.goals / plain.goals
    measured(
        f"{robots} robots that turn in {SPEC.turn_seconds} s, {planner} with turn_cost={TURN_COST} "
        "and without, driven through",
        f"{counting.goals:,.0f} and {plain.goals:,.0f} goals an hour ({gain:.2f}), "
        f"{counting.corners:.0f} and {plain.corners:.0f} corners in 100 moves, "
        f"{counting.joules:,.0f} and {plain.joules:,.0f} J a goal",
    )
    assert gain >= MIN_GAIN[planner]
    assert counting.corners < plain.corners
