"""A program that prints digests of plans, which must be the same with compiled kernels.

Each line has a name and the SHA-256 of all cells. No run has a limit of time.
"""

from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256

import numpy as np

from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.lacam import LaCAM, lacam
from agents.mapf.lifelong import run_lifelong
from agents.mapf.lns import Refinement
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner, Situation
from agents.mapf.windows import WindowedPlanner
from helpers.mapf_problems import random_problem
from warehouse_core import random_layout, shelf_layout
from warehouse_core.compiled import IS_COMPILED

HOUR = 3600.0
SEEDS = range(2)


def lifelong() -> Iterator[tuple[str, np.ndarray]]:
    """Yield lifelong runs of planners on floors without lanes, with lanes, and with turns."""
    for seed in SEEDS:
        layout = random_layout(14, 14, 0.2, seed)
        shelves = shelf_layout(3, 3, 4, seed=seed)
        for kind, graph, turn_cost in (
            ("plain", Graph(layout), 0.0),
            ("lanes", Graph(shelves, lane_costs(shelves)), 0.0),
            ("odd", Graph(shelves, lane_costs(shelves, 1.04)), 0.83),
            ("odd lanes", Graph(shelves, lane_costs(shelves, 1.04)), 0.0),
            ("turns", Graph(layout), 2.5),
        ):
            robots = len(graph.layout.open_cells) // 3
            planners = {
                "pibt": PIBT(graph, seed, turn_cost),
                "rollouts": WindowedPlanner(graph, 8, 0, seed=seed, turn_cost=turn_cost),
                "groups": WindowedPlanner(graph, 8, 12, seed=seed, turn_cost=turn_cost),
            }
            for name, planner in planners.items():
                steps = 40 if name == "pibt" else 12
                run = run_lifelong(graph, planner, robots, steps, seed)
                yield f"{name} {kind} {seed}", run.cells
            yield f"disturbed {kind} {seed}", disturbed(planners["groups"], graph, robots, seed)


def disturbed(planner: Planner, graph: Graph, robots: int, seed: int) -> np.ndarray:
    """Return a run in which robots stay, cells are closed, and some robots are urgent."""
    stream, cells = np.random.default_rng(seed), graph.layout.open_cells
    here, goals = (stream.permutation(cells)[:robots] for _ in range(2))
    path = [here]
    planner.reset()
    for _ in range(12):
        stays, urgent = stream.random(robots) < 0.05, stream.integers(robots, size=3)
        closed = stream.permutation(cells)[:4]
        here = planner.next_cells(Situation(here, goals, stays, closed, urgent))
        goals = np.where(here == goals, stream.permutation(cells)[:robots], goals)
        path.append(here)
    return np.array(path)


def once() -> Iterator[tuple[str, np.ndarray]]:
    """Yield plans of whole problems; rounds and trials limit the searches."""
    for seed in SEEDS:
        problem = random_problem(random_layout(14, 14, 0.2, seed), 45, seed)
        plan = lacam(problem, HOUR, seed)
        yield f"lacam {seed}", plan.cells
        guided = LaCAM(problem, seed, window=8)
        guided.search(np.inf, goes_on=False)
        yield f"guided {seed}", guided.plan().cells
        refinement = Refinement(problem, plan, seed)
        refinement.run(np.inf, 60)
        yield f"refinement {seed}", refinement.plan().cells
        for robots, rounds in ((3, 4_000), (12, 1_500)):
            few = random_problem(random_layout(8, 8, 0.2, seed), robots, seed)
            search = LaCAM(few, seed)
            search.search(np.inf, rounds)
            best = search.plan()
            yield f"lacam-star {robots} {seed}", np.array([-1]) if best is None else best.cells


def turning() -> Iterator[tuple[str, np.ndarray]]:
    """Yield lifelong runs and plans of robots with headings."""
    for seed in SEEDS:
        graph = Graph(random_layout(14, 14, 0.2, seed))
        for robots in (60, 100):
            for has_headings in (False, True):
                planner = Circulation(graph.with_costs(lane_costs(graph.layout)), seed)
                run = run_lifelong(graph, planner, robots, 12, seed, has_headings=has_headings)
                yield f"circulation {has_headings} {robots} {seed}", run.cells
            windowed = WindowedPlanner(graph, 6, 8, seed=seed)
            run = run_lifelong(graph, windowed, robots, 8, seed, has_headings=True)
            yield f"windowed {robots} {seed}", run.cells
        for name, costs in (("plain", None), ("lanes", lane_costs(graph.layout, 1.3))):
            for groups in (0, 12):
                windowed = WindowedPlanner(graph.with_costs(costs), 8, groups, seed=seed)
                run = run_lifelong(graph, windowed, 30, 12, seed, has_headings=True)
                yield f"windowed {name} {groups} {seed}", run.cells
        for robots, rounds in ((2, 4_000), (12, 400)):
            ends = random_problem(random_layout(8, 8, 0.2, seed), robots, seed)
            search = LaCAM(replace(ends, headings=[seed] * robots), seed)
            search.search(np.inf, rounds)
            found = search.plan()
            assert found is not None
            yield f"lacam-star turns {robots} {seed}", found.places(ends.graph)
            refinement = Refinement(search.problem, found, seed)
            refinement.run(np.inf, 30)
            yield f"refinement turns {robots} {seed}", refinement.plan().places(ends.graph)


if __name__ == "__main__":
    print("compiled" if IS_COMPILED else "plain")
    for part in (lifelong, once, turning):
        for what, cells in part():
            numbers = np.ascontiguousarray(cells, np.int64)
            print(f"{what}: {sha256(repr(cells.shape).encode() + numbers.tobytes()).hexdigest()}")
