"""Every planner by name on the same problems: plans in 1, 10 and 60 s, and goals without end."""

from math import inf

import numpy as np
import pytest

from agents.lab.commands.planners.floors import PlannerFloor, find_floor, random_problem
from agents.lab.commands.planners.runs import SOLVERS, Attempt, attempt, make_stepper
from agents.mapf.graph import Graph
from agents.mapf.kernels.buffers import IS_COMPILED
from agents.mapf.lifelong import run_lifelong
from agents.registry import PLANNERS
from warehouse_core import random_layout

FLOORS = {"32 x 32 cells, 20% walls": 50, "kiva": 100}
"""Robots on each floor."""

PROBLEMS, SECONDS, STEPS, SEED = 2, (1, 10, 60), 300, 0
SHARE = 0.8
"""A planner that has ended before this share of its time would do the same in more."""

pytestmark = pytest.mark.usefixtures("processor_clock")

FORM = "compiled" if IS_COMPILED else "plain"


def floor_of(name: str) -> PlannerFloor:
    if name == "kiva":
        return find_floor(name)
    layout = random_layout(32, 32, 0.2, seed=SEED)
    return PlannerFloor(layout, layout.open_cells, layout.open_cells)


def said(found: list[Attempt]) -> str:
    plans = [each for each in found if each.costs is not None]
    text = f"{len(plans)} of {len(found)}"
    if plans:
        ratio = np.mean([each.costs / each.bound for each in plans])
        text += f", costs {ratio:.3f}, makespan {np.mean([each.makespan for each in plans]):.0f}"
    proved = sum(each.proved for each in plans)
    return f"{text}, {proved} proved" if proved else text


@pytest.mark.parametrize("planner", SOLVERS)
@pytest.mark.parametrize("floor", FLOORS)
def test_plans(floor: str, planner: str, measured) -> None:
    found: dict[int, list[Attempt]] = {}
    for seed in range(PROBLEMS):
        problem = random_problem(floor_of(floor), FLOORS[floor], seed)
        known = attempt(planner, SEED, problem, SECONDS[0])
        for seconds, before in zip(SECONDS, (inf, *SECONDS), strict=False):
            if known.seconds > SHARE * before:
                known = attempt(planner, SEED, problem, seconds)
            found.setdefault(seconds, []).append(known)
    parts = [f"{seconds} s: {said(each)}" for seconds, each in found.items()]
    measured(f"{planner}, {FLOORS[floor]} robots on {floor} ({FORM})", "; ".join(parts))


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("floor", FLOORS)
def test_goals_without_end(floor: str, planner: str, measured) -> None:
    place, robots = floor_of(floor), FLOORS[floor]
    stepper = make_stepper(planner, SEED, place.layout, robots, 10.0)
    ends = place.starts, place.goals
    run = run_lifelong(Graph(place.layout), stepper, robots, STEPS, SEED, *ends)
    measured(
        f"{planner}, {robots} robots from goal to goal on {floor} ({FORM})",
        f"{run.reached / STEPS:.2f} goals a step, {1000 * np.mean(run.seconds):.1f} ms a step",
    )
