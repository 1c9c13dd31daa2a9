import pytest
from helpers.mapf_problems import random_problem, random_problems
from helpers.mapf_runs import check_planner, check_solver

from agents.mapf.graph import Graph
from agents.mapf.prioritised import WindowedPlanner, solve_prioritised
from agents.mapf.problem import Problem
from warehouse_core import Layout, random_layout
from warehouse_physics import RigidBodyMotion


def problem_of(rows: list[str], starts: list[int], goals: list[int]) -> Problem:
    return Problem(Graph(Layout(rows)), starts, goals)


def test_plans_of_random_problems_are_valid() -> None:
    solved = check_solver(solve_prioritised, random_problems(150, seed=3), seconds=0.2)
    assert solved > 100


def test_plans_are_driven_by_bodies_too() -> None:
    problems = random_problems(5, seed=5)
    assert check_solver(solve_prioritised, problems, 0.2, RigidBodyMotion) > 2


@pytest.mark.parametrize("groups", [0, 5])
def test_windowed_steps_are_valid(groups: int) -> None:
    def make(graph: Graph) -> WindowedPlanner:
        return WindowedPlanner(graph, window=8, replan=3, groups=groups)

    reached = [
        check_planner(make, problem, 30, seed=number)
        for number, problem in enumerate(random_problems(40, seed=4, max_robots=20))
    ]
    assert sum(reached) > 700


def test_windowed_steps_are_driven_by_bodies_too() -> None:
    problem = random_problem(random_layout(10, 10, 0.1, seed=1), 20, seed=1)
    assert check_planner(WindowedPlanner, problem, 30, RigidBodyMotion()) > 40
