"""Solvers and planners on random problems; each plan is validated and carried out by a motion."""

import random
from collections.abc import Callable, Iterable

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.planner import PlacePlanner, Planner, Situation, check_turns
from agents.mapf.problem import Problem, Solver
from helpers.mapf_turns import State, meets, steps_of
from helpers.mapf_validator import check_traffic, plan_conflict, step_conflict
from warehouse_core import Layout
from warehouse_core.motion.base import Motion
from warehouse_core.motion.grid import GridMotion


def check_solver(
    solve: Solver,
    problems: Iterable[Problem],
    seconds: float,
    make_motion: Callable[[], Motion] = GridMotion,
) -> int:
    """Return the number of problems that were solved.

    Raises:
        AssertionError: a plan has a conflict, or the motion blocks a robot.
    """
    solved = 0
    for problem in problems:
        try:
            plan = solve(problem, seconds)
        except PlanError:
            continue
        layout, cells = problem.graph.layout, plan.cells.tolist()
        found = plan_conflict(layout.rows, problem.starts, problem.goals, cells)
        assert found is None, (found, layout.rows, problem.starts, problem.goals)
        check_traffic(make_motion(), layout, cells)
        solved += 1
    return solved


def check_planner(
    make_planner: Callable[[Graph], Planner],
    problem: Problem,
    steps: int,
    motion: Motion | None = None,
    seed: int = 0,
) -> int:
    """Return how many goals robots reach in the layout of a problem, with new goals after each.

    Some robots stay for some steps, some cells are closed and some robots have no goal.

    Raises:
        AssertionError: a step has a conflict, or the motion blocks a robot.
    """
    stream, layout = random.Random(seed), problem.graph.layout
    cells, goals, reached = list(problem.starts), list(problem.goals), 0
    open_cells, path = layout.open_cells.tolist(), [list(cells)]
    planner = make_planner(problem.graph)
    planner.reset()
    for _ in range(steps):
        stays = [stream.random() < 0.05 for _ in cells]
        closed = stream.sample(open_cells, stream.randrange(1 + len(open_cells) // 10))
        given = Situation(np.array(cells), np.array(goals), np.array(stays), np.array(closed, int))
        after = planner.next_cells(given).tolist()
        found = step_conflict(layout.rows, cells, after, stays, closed)
        assert found is None, (found, layout.rows, given, after)
        cells = after
        path.append(cells)
        for robot, cell in enumerate(cells):
            if cell == goals[robot]:
                reached += not stays[robot]
                goals[robot] = cell if stream.random() < 0.2 else stream.choice(open_cells)
    check_traffic(motion or GridMotion(), layout, path)
    return reached


def check_headed_planner(
    make_planner: Callable[[Graph], PlacePlanner], layout: Layout, robots: int
) -> int:
    """Return how many goals robots with headings reach in 30 steps.

    Some robots stay for some steps, and some cells are closed.

    Raises:
        AssertionError: a step breaks the rules.
    """
    graph, stream, reached = Graph(layout), np.random.default_rng(robots), 0
    planner = make_planner(graph)
    cells, goals = (stream.permutation(layout.open_cells)[:robots] for _ in range(2))
    headings = stream.integers(4, size=robots)
    for _ in range(30):
        stays, closed = stream.random(robots) < 0.05, stream.permutation(layout.open_cells)[:3]
        situation = Situation(cells, goals, stays, closed)
        places = check_turns(graph, situation, headings, planner.next_places(situation, headings))
        before = state_of(layout, cells, headings)
        headings, cells = np.divmod(places, graph.size)
        after = state_of(layout, cells, headings)
        assert not meets(before, after)
        for one, other, is_fixed in zip(before, after, stays, strict=True):
            assert other == one if is_fixed else other in steps_of(layout.rows, one)
            assert other[:2] == one[:2] or other[:2] not in layout.cells(closed)
        reached += int((cells == goals).sum())
        goals = np.where(cells == goals, stream.permutation(layout.open_cells)[:robots], goals)
    return reached


def state_of(layout: Layout, cells: np.ndarray, headings: np.ndarray) -> State:
    pairs = zip(layout.cells(cells), headings.tolist(), strict=True)
    return tuple((*cell, heading) for cell, heading in pairs)
