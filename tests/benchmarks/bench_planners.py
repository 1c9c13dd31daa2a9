"""Planners for several robots: plans, goals and times, compared with bounds and other programs.

``MOVINGAI_DATA`` names a folder with a subfolder for each map, as unpacked from
movingai.com/benchmarks/mapf. A subfolder has the map and its scenarios, of which the first random
one is used.
"""

import os
import time
from contextlib import suppress
from dataclasses import replace
from math import inf
from pathlib import Path
from statistics import median

import numpy as np
import pytest
from helpers.mapf_problems import random_problem as drawn_problem
from helpers.mapf_turns import turning_conflict
from helpers.mapf_validator import plan_conflict

from agents.errors import PlanError
from agents.lab.commands.planners.runs import (
    SOLVERS,
    Attempt,
    PlannerFloor,
    attempt,
    find_floor,
    make_stepper,
    random_problem,
    scenario_problem,
)
from agents.mapf.anytime import solve_anytime
from agents.mapf.cbs import ConflictTree
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.lifelong import run_lifelong
from agents.registry import PLANNERS
from warehouse_core import random_layout
from warehouse_core.compiled import IS_COMPILED
from warehouse_core.world.moves import EAST

FLOORS = {"32 x 32 cells, 20% walls": 50, "kiva": 100}
"""Number of robots in each layout."""

PROBLEMS, SECONDS, STEPS, SEED = 2, (1, 10, 60), 300, 0
SHARE = 0.8
"""Share of its time limit. A planner that ends earlier would find the same plan with more time."""

FORM = "compiled" if IS_COMPILED else "plain"

pytestmark = pytest.mark.usefixtures("processor_clock")


def floor_of(name: str) -> PlannerFloor:
    if name == "kiva":
        return find_floor(name)
    layout = random_layout(32, 32, 0.2, seed=SEED)
    return PlannerFloor(layout, layout.open_cells, layout.open_cells)


def described(found: list[Attempt]) -> str:
    plans = [each for each in found if each.costs is not None]
    text = f"{len(plans)} of {len(found)} solved"
    if plans:
        ratio = np.mean([each.costs / each.bound for each in plans])
        text += f", costs {ratio:.3f}, makespan {np.mean([each.makespan for each in plans]):.0f}"
    proved = sum(each.proved for each in plans)
    return f"{text}, {proved} proved optimal" if proved else text


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
    parts = [f"{seconds} s: {described(each)}" for seconds, each in found.items()]
    measured(f"{planner}, {FLOORS[floor]} robots on {floor} ({FORM})", "; ".join(parts))


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("floor", FLOORS)
def test_one_goal_after_another(floor: str, planner: str, measured) -> None:
    place, robots = floor_of(floor), FLOORS[floor]
    stepper = make_stepper(planner, SEED, place.layout, robots, 10.0)
    ends = place.starts, place.goals
    run = run_lifelong(Graph(place.layout), stepper, robots, STEPS, SEED, *ends)
    measured(
        f"{planner}, {robots} robots with one goal after another on {floor} ({FORM})",
        f"{run.reached / STEPS:.2f} goals per step, {1000 * np.mean(run.seconds):.1f} ms per step",
    )


SCENARIOS = {
    ("random-32-32-20", 409, 30): 1.8,
    ("maze-32-32-4", 300, 30): 2.8,
    ("warehouse-10-20-10-2-1", 1_000, 30): 2.0,
    ("den312d", 1_000, 30): 4.5,
    ("Paris_1_256", 1_000, 30): 1.02,
    ("random-32-32-20", 100, 10): 1.12,
    ("random-32-32-20", 400, 10): 2.27,
    ("warehouse-10-20-10-2-1", 400, 10): 1.13,
}
"""Maximum ratio of the sum of costs to its lower bound, by map, robots and seconds.

The ratios of random-32-32-20 in 10 s are results of LaCAM3, built and run on this kind of machine.
"""


@pytest.mark.parametrize("place", SCENARIOS, ids=str)
def test_scenarios(place: tuple[str, int, int], measured) -> None:
    name, robots, seconds = place
    file = Path(os.environ["MOVINGAI_DATA"], name, f"{name}-random-1.scen")
    problem = scenario_problem(file, str(file.with_name(f"{name}.map")), robots)
    plan = solve_anytime(problem, seconds)
    rows = problem.graph.layout.rows
    assert plan_conflict(rows, problem.starts, problem.goals, plan.cells.tolist()) is None
    ratio = plan.sum_of_costs / problem.lower_bound
    what = f"{name}, {robots} robots, {seconds} s, ratio of costs to the lower bound ({FORM})"
    measured(what, f"{ratio:.3f}")
    assert ratio <= SCENARIOS[place]


FIRST_SECONDS = {0.5: 2.51, 5.0: 1.86}
"""Published ratios of LG-LaCAM, with 400 robots on 785 of 32 x 32 cells, by seconds."""


@pytest.mark.parametrize("seconds", FIRST_SECONDS)
def test_plans_of_crowds_in_the_first_seconds(seconds: float, measured) -> None:
    ratios = []
    for seed in range(16):
        problem = drawn_problem(random_layout(34, 34, 0.2334, seed), 400, seed)
        with suppress(PlanError):  # no plan was found in time
            ratios.append(solve_anytime(problem, seconds, seed).sum_of_costs / problem.lower_bound)
    cells, mean = len(problem.graph.layout.open_cells), np.mean(ratios)
    measured(
        f"400 robots on {cells} cells, {seconds:g} s, ratio of costs to the lower bound ({FORM})",
        f"{len(ratios)} of 16 solved, mean {mean:.2f}, worst {max(ratios):.2f}; LG-LaCAM "
        f"{FIRST_SECONDS[seconds]}",
    )
    assert len(ratios) > 10
    assert mean <= 1.2 * FIRST_SECONDS[seconds]


TURNING = {50: 1.08, 200: 1.42, 400: 4.8}
"""Maximum ratio of the sum of costs to its lower bound with headings after 10 s, by robots."""


@pytest.mark.parametrize("robots", TURNING)
def test_plans_of_robots_with_headings(robots: int, measured) -> None:
    plain, times = [], []
    for seed in range(5):
        problem = drawn_problem(random_layout(32, 32, 0.2, seed), robots, seed)
        turning = replace(problem, headings=[EAST] * robots)
        for each, kept in ((problem, plain), (turning, times)):
            start = time.perf_counter()
            plan = lacam(each, 10.0, seed)
            kept.append(time.perf_counter() - start)
        assert turning_conflict(turning, plan) is None
    better = solve_anytime(turning, 10.0)
    assert turning_conflict(turning, better) is None
    best = better.sum_of_costs / turning.lower_bound
    measured(
        f"LaCAM with headings, {robots} robots, 5 maps of 32 x 32 cells, 20% walls",
        f"{median(times):.3f} s, without headings {median(plain):.3f} s; ratio of costs to the "
        f"lower bound on the last map {plan.sum_of_costs / turning.lower_bound:.2f}, and "
        f"{best:.2f} with anytime in 10 s",
    )
    assert best <= TURNING[robots]
    assert median(times) < 10 * median(plain)


@pytest.mark.parametrize(("robots", "walls"), [(20, 10), (40, 20)])
def test_seconds_of_conflict_based_search(robots: int, walls: int, measured) -> None:
    """The layouts have 32 x 32 connected cells with some walls inside a border."""
    times, late = [], 0
    for seed in range(25):
        problem = drawn_problem(random_layout(34, 34, walls / 100, seed), robots, seed)
        tree, start = ConflictTree(problem), time.process_time()
        try:
            tree.solve(20.0)
        except PlanError:
            late += 1
        times.append(time.process_time() - start)
    measured(
        f"CPU seconds of CBS, {robots} robots on 25 layouts like random-32-32-{walls}",
        f"median {median(times):.3f}, worst {max(times):.2f}; {late} without a plan in 20 s",
    )
