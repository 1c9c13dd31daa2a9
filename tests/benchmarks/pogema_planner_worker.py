"""Runs a planner of ``agents.mapf`` inside POGEMA, in a process of its own; see the benchmark.

Reads a line of JSON with the map, in which ``@`` are starts, ``$`` goals and ``!`` other floor, and
then lines of JSON, each an episode; for each it writes a line of JSON with POGEMA's throughput and
the seconds of the planner by the clock.
"""

import json
import sys
import time

import numpy as np
from pogema import GridConfig, pogema_v0

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Situation
from agents.mapf.traffic import learned_costs
from agents.mapf.windows import WindowedPlanner
from warehouse_core.world.layout import Layout

HEAVY = {"pettingzoo", "typer", "rich", "matplotlib"}

MOVES = np.array([1, 4, 2, 3, 0])
"""POGEMA's numbers of N, E, S, W and waiting."""


def cells_of(pairs, width: int) -> np.ndarray:
    return np.array([row * width + col for row, col in pairs])


def marked(text: list[str], marks: str) -> np.ndarray:
    return np.flatnonzero(np.isin(list("".join(text)), list(marks)))


def make_graph(given: dict, episode: dict) -> Graph:
    """Return the graph with the costs that an episode asks for; learned from POGEMA's marks."""
    layout = Layout([row.translate(str.maketrans("@$!", "...")) for row in given["map"]])
    costs, robots = episode["costs"], episode["robots"]
    if costs == "learned":
        starts, goals = (marked(given["map"], marks) for marks in ("@", "$"))
        return Graph(layout, learned_costs(layout, robots, seed=10_000, starts=starts, goals=goals))
    return Graph(layout, None if costs is None else lane_costs(layout, costs))


def run(given: dict, episode: dict, graph: Graph) -> dict:
    """Return POGEMA's measures of an episode."""
    config = GridConfig(
        map="\n".join(given["map"]),
        num_agents=episode["robots"],
        obs_radius=5,
        collision_system="soft",
        on_target="restart",
        observation_type="MAPF",
        max_episode_steps=episode["steps"],
        seed=episode["seed"],
    )
    make = {"pibt": PIBT, "windowed": WindowedPlanner}[episode["planner"]]
    planner, env, width = make(graph, **episode["options"]), pogema_v0(config), graph.layout.width
    env.reset()
    base = env.unwrapped
    nobody, none = np.zeros(episode["robots"], np.bool_), np.empty(0, np.intp)
    seconds, truncated, metrics = 0.0, [False], {}
    while not all(truncated):
        cells = cells_of(base.get_agents_xy(ignore_borders=True), width)
        goals = cells_of(base.get_targets_xy(ignore_borders=True), width)
        begin = time.perf_counter()
        chosen = planner.next_cells(Situation(cells, goals, nobody, none))
        seconds += time.perf_counter() - begin
        moves = (graph.neighbours[cells] == chosen[:, None]).argmax(axis=1)
        _, _, _, truncated, infos = env.step(MOVES[moves].tolist())
        reached = cells_of(base.get_agents_xy(ignore_borders=True), width)
        assert (reached == chosen).all(), "POGEMA has blocked a move"
        metrics = infos[0].get("metrics", {})
    return {"throughput": metrics["avg_throughput"], "seconds": seconds}


def main() -> None:
    given, graphs = json.loads(sys.stdin.readline()), dict[str, Graph]()
    assert not HEAVY & sys.modules.keys(), HEAVY & sys.modules.keys()
    for line in sys.stdin:
        episode = json.loads(line)
        key = str((episode["costs"], episode["robots"]))
        if key not in graphs:
            graphs[key] = make_graph(given, episode)
        print(json.dumps(run(given, episode, graphs[key])), flush=True)


if __name__ == "__main__":
    main()
