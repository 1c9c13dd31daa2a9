"""Search algorithms, search problems, heuristics, and agents that plan by searching."""

from agents.search.agents import ExploringAgent, SearchAgent
from agents.search.algorithms import (
    Problem,
    Solution,
    astar_search,
    best_first_search,
    breadth_first_search,
    greedy_best_first_search,
    uniform_cost_search,
    weighted_astar_search,
)
from agents.search.heuristics import manhattan, manhattan_delivery, true_distance
from agents.search.problems import DeliveryProblem, RouteProblem

__all__ = [
    "DeliveryProblem",
    "ExploringAgent",
    "Problem",
    "RouteProblem",
    "SearchAgent",
    "Solution",
    "astar_search",
    "best_first_search",
    "breadth_first_search",
    "greedy_best_first_search",
    "manhattan",
    "manhattan_delivery",
    "true_distance",
    "uniform_cost_search",
    "weighted_astar_search",
]
