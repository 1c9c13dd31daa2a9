"""A program that prints digests of episodes, plans and learning; a browser prints the same."""

import hashlib
import warnings
from typing import Any

from agents.learning import QTable
from agents.learning.q_learning import learn
from agents.mapf.anytime import solve_anytime
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.problem import Problem
from agents.registry import make_agent, make_fleet_agent
from warehouse_core import (
    Episode,
    FleetEnv,
    OrderStream,
    WarehouseEnv,
    random_layout,
    record_episode,
    record_fleet_episode,
    shelf_layout,
)

FLEETS = [
    (planner, seed)
    for planner in ("auto", "pibt", "pibt:guidance=lanes", "windowed", "windowed:guidance=lanes")
    for seed in range(5)
]


def digest_of(*parts: Any) -> str:
    """Return a digest of the texts of values."""
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:16]


def course(episode: Episode) -> str:
    """Return a digest of the course of an episode."""
    return digest_of(
        episode.layout.rows,
        *(list(map(str, column)) for column in (episode.cells, episode.actions, episode.rewards)),
    )


def alone(name: str, episodes: int) -> str:
    """Return a digest of the episodes of an agent."""
    agents = ((seed, make_agent(name, seed)) for seed in range(episodes))
    return digest_of(
        *(course(record_episode(WarehouseEnv(), agent, seed=seed)) for seed, agent in agents)
    )


def fleet(planner: str, seed: int) -> str:
    """Return a digest of a shift of a fleet with orders, chargers and a person."""
    layout = shelf_layout(chargers=2)
    env = FleetEnv(layout, 4, orders=OrderStream(0.2), people=seed % 2, battery=100, max_steps=100)
    agent = make_fleet_agent(planner, "urgent", seed, layout, 4)
    return course(record_fleet_episode(env, agent, seed=seed))


def refined() -> str:
    """Return a digest of a plan for a crowded layout, after guidance and refinement."""
    layout = random_layout(16, 16, 0.2, seed=2)
    cells = layout.open_cells.tolist()
    problem = Problem(Graph(layout), cells[:24], cells[-24:])
    return digest_of(solve_anytime(problem, 120.0, trials=20).cells.tolist())


def plan() -> str:
    """Return a digest of a joint plan."""
    layout = shelf_layout()
    starts, goals = layout.numbers(layout.pickups), layout.numbers(layout.dropoffs)
    pairs = min(len(starts), len(goals))
    problem = Problem(Graph(layout), starts[:pairs].tolist(), goals[:pairs].tolist())
    return digest_of(lacam(problem, 60.0).cells.tolist())


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # one says that there are no threads
    print("greedy", alone("greedy", 200))
    for name in ("astar", "exploring"):
        print(name, alone(name, 20))
    for planner, seed in FLEETS:
        print(planner, seed, fleet(planner, seed))
    print("lacam", plan())
    print("anytime", refined())
    print("q", digest_of(list(learn(QTable(), WarehouseEnv(), 5000, seed=0))))
