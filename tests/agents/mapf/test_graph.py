"""Graphs of layouts, the distances in them, and planners that count turns."""

from itertools import pairwise, product

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.errors import AgentError, PlanError
from agents.mapf import graph as module
from agents.mapf.circulation import Circulation
from agents.mapf.graph import CLOSED, Fields, Graph, HeadedFields
from agents.mapf.guidance import lane_costs
from agents.mapf.kernels.places import FAR
from agents.mapf.pibt import PIBT
from agents.mapf.planner import NO_CELLS, Planner, Situation, check_step, check_turns
from agents.mapf.problem import Problem
from agents.mapf.windows import WindowedPlanner
from agents.registry import make_planner
from warehouse_core import Layout, random_layout
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.tiles import moved

ROOM = Layout(["..#.", "....", "##.#"])


def test_neighbours_are_north_east_south_west_and_the_cell_itself() -> None:
    graph = Graph(ROOM)
    assert graph.neighbours[5].tolist() == [1, 6, CLOSED, 4, 5]
    assert graph.neighbours[0].tolist() == [CLOSED, 1, 4, CLOSED, 0]
    assert graph.neighbours[2].tolist() == [CLOSED] * 5


def test_fields_that_were_not_used_lately_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = Graph(ROOM)
    monkeypatch.setattr(module, "MAX_BYTES", 2 * graph.distances(0).nbytes)
    kept = graph.distances(0)
    graph.distances(1)
    assert graph.distances(0) is kept
    graph.distances(4)
    assert graph.distances(0) is kept


def test_rows_of_goals_that_nobody_has_are_used_again(monkeypatch: pytest.MonkeyPatch) -> None:
    layout = random_layout(20, 20, 0.1, 0)
    graph = Graph(layout)
    fields, cells = Fields(graph), layout.open_cells
    monkeypatch.setattr(module, "MAX_BYTES", 64 * fields.matrix[:1].nbytes + 1)
    for start in range(0, 240, 40):
        goals = cells[start : start + 60]
        rows = fields.rows(goals)
        for goal, row in zip(goals.tolist(), rows.tolist(), strict=True):
            expected = np.minimum(graph.distances(goal), FAR)
            assert fields.matrix[row].tolist() == expected.tolist()
    assert len(fields.matrix) <= 160


@pytest.mark.parametrize("kind", [Fields, HeadedFields])
def test_rows_follow_the_cells_that_are_closed(kind: type[Fields]) -> None:
    graph, goals = Graph(ROOM), np.array([0, 7])
    fields = kind(graph)
    for closed in ([], [5], [], [6]):
        graph.close(frozenset(closed))
        fresh = kind(graph)
        rows, expected = fields.rows(goals), fresh.rows(goals)
        assert np.array_equal(fields.matrix[rows], fresh.matrix[expected]), closed
        assert np.array_equal(fields.near, fresh.near), closed


HEADED = [Circulation, WindowedPlanner]


@pytest.mark.parametrize(("make", "has_headings"), [(PIBT, False), *product(HEADED, (False, True))])
def test_closed_cells_are_entered_once_they_are_open(make, has_headings) -> None:
    """A robot goes round closed cells, and then into one of them."""
    graph = Graph(Layout([".....", ".###.", "....."]))
    planner, cells, headings = make(graph), np.array([0]), np.array([1])
    for step in range(40):
        graph.close(frozenset([[2], [], [2], [12], []][min(step // 2, 4)]))
        closed = np.array(sorted(graph.closed), np.intp)
        given = situation(cells, [4 if step < 20 else 2])._replace(closed=closed)
        if has_headings:
            headings, cells = np.divmod(planner.next_places(given, headings), graph.size)
        else:
            cells = planner.next_cells(given)
        assert cells[0] not in graph.closed
        assert step != 19 or cells[0] == 4
    assert cells.tolist() == [2]


@pytest.mark.parametrize("make", HEADED)
@pytest.mark.parametrize("has_headings", [False, True])
def test_crowds_keep_out_of_cells_that_are_closed_now_and_then(make, has_headings) -> None:
    """Pushed robots also avoid closed cells, even if only the graph knows of them."""
    graph, stream = Graph(random_layout(9, 9, 0.1, seed=4)), np.random.default_rng(5)
    planner, open_cells = make(graph), graph.layout.open_cells
    cells, headings, goals = (
        stream.permutation(open_cells)[:12],
        np.ones(12, np.intp),
        open_cells[:12],
    )
    for step in range(20):
        if step % 4 == 0:
            free = np.setdiff1d(open_cells, cells)
            graph.close(frozenset(stream.permutation(free)[:5].tolist()))
            goals = stream.permutation(open_cells)[:12]
        given = situation(cells, goals, closed=sorted(graph.closed)[:2])
        before = cells
        if has_headings:
            places = planner.next_places(given, headings)
            headings, cells = np.divmod(check_turns(graph, given, headings, places), graph.size)
        else:
            cells = check_step(graph, given, planner.next_cells(given))
        entered = cells[cells != before].tolist()
        assert graph.closed.isdisjoint(entered)
        if isinstance(planner, WindowedPlanner):
            paths = planner._places % graph.size
            moves = paths[:, 1:] != paths[:, :-1]
            assert graph.closed.isdisjoint(paths[:, 1:][moves].tolist())


@pytest.mark.parametrize("cost", [1.5, 30_000.0])
def test_distances_on_lanes_count_in_tenths_of_a_step(cost: float) -> None:
    layout = Layout(["....", "..#."])
    graph = Graph(layout, lane_costs(layout, cost))
    fields = Fields(graph)
    for goal in (0, 3, 7):
        row = fields.rows(np.array([goal]))[0]
        expected = graph.distances(goal)
        reachable = np.isfinite(expected)
        assert fields.matrix[row][reachable].tolist() == (10 * expected[reachable]).tolist()
    assert fields.matrix[row][6] == FAR


# Turns.


HALL = Layout(["......"] * 6)
PLANNERS = [
    pytest.param(lambda graph, cost: PIBT(graph, 0, cost), id="pibt"),
    pytest.param(lambda graph, cost: WindowedPlanner(graph, turn_cost=cost), id="windowed"),
]


def relaxed(layout: Layout, costs: np.ndarray, goal: int, turn_cost: float) -> np.ndarray:
    """Return the distances ``[4, H * W]`` by relaxing all moves until nothing changes."""
    found = np.full((4, layout.height * layout.width), np.inf)
    found[:, goal] = 0
    while True:
        before = found.copy()
        for heading, cell, move in product(range(4), layout.open_cells.tolist(), range(4)):
            there = moved(layout.cell(cell), DISPLACEMENTS[move])
            if layout.is_open(there):
                quarters = min((heading - move) % 4, (move - heading) % 4)
                cost = costs[cell, move] + quarters * turn_cost + found[move, layout.number(there)]
                found[heading, cell] = min(found[heading, cell], cost)
        if (found == before).all():
            return found


@pytest.mark.parametrize("turn_cost", [0, 2.5])
@pytest.mark.parametrize("seed", range(2))
def test_distances_are_those_of_another_algorithm(turn_cost: float, seed: int) -> None:
    """Costs apply to moves towards the goal, not away from it."""
    layout = random_layout(6, 7, 0.25, seed)
    some = np.random.default_rng(seed).integers(1, 9, (42, 4)).astype(np.float32)
    goal = int(layout.open_cells[seed])
    for costs in (some, None):
        found = Graph(layout, costs, turn_cost).distances(goal).reshape(-1, 42)
        expected = relaxed(layout, np.ones((42, 4)) if costs is None else costs, goal, turn_cost)
        assert found.tolist() == expected[: len(found)].tolist()


def test_a_cheapest_path_has_the_fewest_turns() -> None:
    path = Graph(HALL, turn_cost=0.1).path(0, 35)
    assert len(path) == 11
    assert corners(path) == 1
    assert Graph(Layout([".#."]), turn_cost=1).path(0, 2) == [0]


def corners(path: list[int]) -> int:
    moves = [to - cell for cell, to in pairwise(path) if to != cell]
    return sum(move != after for move, after in pairwise(moves))


def drive(planner: Planner, cells: list[int], goal: int, steps: int) -> list[int]:
    """Return the path on which a planner moves a robot that has been in some cells."""
    path = cells[:1]
    for step in range(steps):
        here, nobody = np.array(path[-1:]), np.zeros(1, np.bool_)
        is_forced = step + 1 < len(cells)
        wanted = cells[step + 1] if is_forced else goal
        found = planner.next_cells(Situation(here, np.array([wanted]), nobody, NO_CELLS))
        path.append(int(found[0]))
    return path


@pytest.mark.parametrize("make", PLANNERS)
@pytest.mark.parametrize(("before", "goal", "expected"), [(13, 21, 15), (8, 21, 20), (20, 9, 8)])
def test_a_robot_goes_on_in_the_direction_of_its_last_move(make, before, goal, expected) -> None:
    """The robot drives from the middle, 14, to a corner of its diagonal."""
    path = drive(make(Graph(HALL), 1.0), [before, 14], goal, 3)
    assert path[1:3] == [14, expected]


def test_names_of_planners_may_give_the_cost_of_turns() -> None:
    layout = Layout(["P..D", "...."])
    for name in ("pibt", "pibt:guidance=lanes", "windowed", "windowed:guidance=lanes"):
        separator = "," if ":" in name else ":"
        planner = make_planner(f"{name}{separator}turn_cost=0.5", 0, layout, 2)
        assert planner.graph.turn_cost == 0.5
        assert make_planner(name, 0, layout, 2).graph.turn_cost == 0
    with pytest.raises(AgentError, match=r"turn_cost is -1; it must be at least 0"):
        make_planner("pibt:turn_cost=-1", 0, layout)


def test_problems_with_costs_of_turns_are_refused() -> None:
    with pytest.raises(
        PlanError, match=r"^turn_cost of the graph is 2.0; in a problem it must be 0"
    ):
        Problem(Graph(HALL, turn_cost=2), [0], [1])
