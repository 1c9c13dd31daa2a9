"""Every plan of every planner on random problems: validated, and driven by both backends."""

import time

import pytest
from helpers.mapf_problems import random_problem, random_problems
from helpers.mapf_runs import check_planner, check_solver

from agents.mapf.anytime import solve_anytime
from agents.mapf.cbs import solve_cbs
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.lanes import lane_costs
from agents.mapf.pibt import PIBT, pibt
from agents.mapf.planner import Planner
from agents.mapf.windows import WindowedPlanner
from warehouse_core import random_layout
from warehouse_core.motion.grid import GridMotion
from warehouse_physics import RigidBodyMotion

PROBLEMS, ON_BODIES = 2_000, 100
SOLVERS = {
    "cbs": solve_cbs,
    "lacam": lacam,
    "anytime": solve_anytime,
    "pibt": pibt,
}
MOTIONS = {"grid": (GridMotion, PROBLEMS), "physics": (RigidBodyMotion, ON_BODIES)}


def improved(graph: Graph) -> Planner:
    return WindowedPlanner(graph, window=10, groups=5)


def cut_off(graph: Graph) -> Planner:
    """Return a planner that often has too little time."""
    return WindowedPlanner(graph, seconds=0.0005)


def on_lanes(graph: Graph) -> Planner:
    return PIBT(Graph(graph.layout, lane_costs(graph.layout)))


PLANNERS = {
    "pibt": PIBT,
    "pibt on lanes": on_lanes,
    "windowed": WindowedPlanner,
    "improved": improved,
    "cut off": cut_off,
}


@pytest.mark.parametrize("backend", MOTIONS)
@pytest.mark.parametrize("name", SOLVERS)
def test_plans_are_valid(name: str, backend: str, measured) -> None:
    make, count = MOTIONS[backend]
    start = time.process_time()
    solved = check_solver(SOLVERS[name], random_problems(count, seed=9), 0.1, make)
    seconds = time.process_time() - start
    what = f"plans of {name} that are valid and driven without a blocked move, {backend}"
    measured(what, f"{solved} of {solved} ({count} problems, 0.1 s each, {seconds:.0f} s)")


@pytest.mark.parametrize("backend", MOTIONS)
@pytest.mark.parametrize("name", PLANNERS)
def test_steps_are_valid(name: str, backend: str, measured) -> None:
    """20 steps of each problem, with people, robots that stay and robots without a goal."""
    make, count = MOTIONS[backend]
    problems = random_problems(count, seed=11, max_robots=25)
    reached = sum(
        check_planner(PLANNERS[name], problem, 20, make(), seed=number)
        for number, problem in enumerate(problems)
    )
    what = f"runs of {name} that are valid and driven without a blocked move, {backend}"
    measured(what, f"{count} of {count}, {reached:,} goals")


def test_many_robots_on_both_backends() -> None:
    problem = random_problem(random_layout(24, 24, 0.1, seed=2), 120, seed=2)
    for motion in (GridMotion(), RigidBodyMotion()):
        assert check_planner(WindowedPlanner, problem, 100, motion) > 500
