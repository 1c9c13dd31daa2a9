"""Local guidance: robots plan their next steps around the plans of others."""

import numpy as np
import pytest
from helpers.mapf_problems import problem_of, random_problem
from helpers.mapf_validator import plan_conflict

from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.kernels.local_guidance import COLLISION, guidance_of, guide
from agents.mapf.kernels.places import NONE
from agents.mapf.lacam import LaCAM
from agents.mapf.problem import Problem
from warehouse_core import random_layout

HOUR, STEPS = 3600.0, 6


class Guided:
    """The guiding paths of the robots of a problem, in the order of their numbers."""

    def __init__(self, rows: list[str], starts: list[int], goals: list[int]) -> None:
        self._search = search = LaCAM(problem_of(rows, starts, goals))
        self.robots = search._robots
        self.robots.places[:] = self.robots.order[:] = np.arange(len(starts))
        self.robots.places[:] = starts
        self.guidance = guidance_of(search.problem.graph.size, len(starts), STEPS)
        self.wishes = np.full(len(starts), NONE)

    def paths(self, is_new: bool = True) -> list[list[int]]:
        fields = self._search._steps, self._search._search.rows
        guide(self._search._floor, self.robots, self.guidance, *fields, self.wishes, is_new)
        return np.asarray(self.guidance.paths).reshape(-1, STEPS + 1).tolist()


def test_a_path_is_a_shortest_one_and_ends_at_the_goal() -> None:
    assert Guided(["....", "####"], [0], [3]).paths() == [[0, 1, 2, 3, 3, 3, 3]]


@pytest.mark.parametrize(
    ("rows", "detour"),
    [
        (["......", "######"], 0),  # no path around the other robot exists
        (["......", "#....#"], 2),
    ],
)
def test_a_path_avoids_others_if_that_costs_less_than_a_collision(rows, detour) -> None:
    guided = Guided(rows, [0, 5], [5, 0])
    first, second = guided.paths()
    assert len(set(first)) == 6
    meetings = sum(one == other for one, other in zip(first, second, strict=True))
    swaps = sum(first[time : time + 2] == second[time : time + 2][::-1] for time in range(STEPS))
    assert meetings + swaps == (detour == 0)
    assert detour < COLLISION


def test_robots_that_follow_their_paths_keep_them_and_others_do_not_collide_with_lost_ones() -> (
    None
):
    guided = Guided(["......", "......"], [0, 5], [5, 0])
    first = guided.paths()[0]
    guided.robots.places[:] = first[1], 11  # the second robot was pushed aside
    after, pushed = guided.paths()
    assert after[:STEPS] == first[1:]
    assert pushed[0] == 11
    counted = np.asarray(guided.guidance.occupied).reshape(STEPS + 1, -1)
    assert counted[1:].sum(axis=1).tolist() == [2] * STEPS
    assert all(counted[1:][time, after[time + 1]] for time in range(STEPS))


def test_a_configuration_that_is_visited_again_is_not_guided() -> None:
    guided = Guided(["....", "...."], [0], [3])
    guided.paths()
    assert guided.wishes.tolist() == [1]
    guided.paths(is_new=False)
    assert guided.wishes.tolist() == [NONE]


@pytest.mark.parametrize("seed", range(3))
def test_guided_plans_of_crowds_are_valid_and_cheaper(seed: int) -> None:
    layout = random_layout(14, 14, 0.2, seed)
    ends = random_problem(layout, 60, seed)
    graph = Graph(layout, lane_costs(layout) if seed == 2 else None)
    problem, costs = Problem(graph, ends.starts, ends.goals), []
    for window in (0, 16):
        search = LaCAM(problem, seed, window)
        search.search(np.inf, goes_on=False)
        plan = search.plan()
        assert plan_conflict(layout.rows, ends.starts, ends.goals, plan.cells) is None
        costs.append(plan.sum_of_costs)
    assert costs[1] < 0.85 * costs[0]
