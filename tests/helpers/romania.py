"""Russell and Norvig's map of Romania, and problems whose states are the names of places.

Source: Russell and Norvig, Artificial Intelligence, 4th ed., figures 3.1 (roads, in miles) and
3.16 (straight-line distances to Bucharest).
"""

from collections.abc import Iterable, Mapping

from agents.search.algorithms import Problem

ROADS = {
    ("Arad", "Zerind"): 75, ("Arad", "Sibiu"): 140, ("Arad", "Timisoara"): 118,
    ("Zerind", "Oradea"): 71, ("Oradea", "Sibiu"): 151, ("Timisoara", "Lugoj"): 111,
    ("Lugoj", "Mehadia"): 70, ("Mehadia", "Drobeta"): 75, ("Drobeta", "Craiova"): 120,
    ("Craiova", "Rimnicu Vilcea"): 146, ("Craiova", "Pitesti"): 138,
    ("Sibiu", "Rimnicu Vilcea"): 80, ("Sibiu", "Fagaras"): 99,
    ("Rimnicu Vilcea", "Pitesti"): 97, ("Fagaras", "Bucharest"): 211,
    ("Pitesti", "Bucharest"): 101, ("Bucharest", "Giurgiu"): 90, ("Bucharest", "Urziceni"): 85,
    ("Urziceni", "Hirsova"): 98, ("Hirsova", "Eforie"): 86, ("Urziceni", "Vaslui"): 142,
    ("Vaslui", "Iasi"): 92, ("Iasi", "Neamt"): 87,
}  # fmt: skip

STRAIGHT_LINE = {
    "Arad": 366, "Bucharest": 0, "Craiova": 160, "Drobeta": 242, "Eforie": 161, "Fagaras": 176,
    "Giurgiu": 77, "Hirsova": 151, "Iasi": 226, "Lugoj": 244, "Mehadia": 241, "Neamt": 234,
    "Oradea": 380, "Pitesti": 100, "Rimnicu Vilcea": 193, "Sibiu": 253, "Timisoara": 329,
    "Urziceni": 80, "Vaslui": 199, "Zerind": 374,
}  # fmt: skip


class Travel(Problem[str, str]):
    """Travel on one-way roads, where an action is the name of the next place."""

    def __init__(self, roads: Mapping[tuple[str, str], float], start: str, goal: str) -> None:
        self.initial = start
        self.goal = goal
        self.roads = roads

    def is_goal(self, state: str) -> bool:
        return state == self.goal

    def actions(self, state: str) -> Iterable[str]:
        return [there for here, there in self.roads if here == state]

    def result(self, state: str, action: str) -> str:
        return action

    def action_cost(self, state: str, action: str, successor: str) -> float:
        return self.roads[state, successor]


def romania(start: str = "Arad", goal: str = "Bucharest") -> Travel:
    """Return Russell and Norvig's problem, in which roads lead in both directions."""
    back = {(there, here): miles for (here, there), miles in ROADS.items()}
    return Travel(ROADS | back, start, goal)


def straight_line(state: str) -> float:
    """Return the straight-line distance to Bucharest in miles."""
    return STRAIGHT_LINE[state]
