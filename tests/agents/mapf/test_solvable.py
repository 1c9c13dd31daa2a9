"""Proofs that there is no plan, against all configurations that robots can reach."""

from collections.abc import Iterator

import numpy as np
import pytest

from agents.errors import PlanError
from agents.lab.commands.planners.runs import solve_checked
from agents.mapf import solvable
from agents.mapf.graph import CLOSED, Graph
from agents.mapf.problem import Plan, Problem
from agents.mapf.solvable import MAX_CELLS, PairMoves, _reach, check_solvable
from warehouse_core import Layout

Cells = tuple[int, ...]


def next_cells(near: dict[int, list[int]], cells: Cells) -> Iterator[Cells]:
    """Return the cells after a robot moves into a free cell, and after a ring turns."""
    robot_in = {cell: robot for robot, cell in enumerate(cells)}

    def rings(way: Cells) -> Iterator[Cells]:
        for cell in near[way[-1]]:
            if cell == way[0] and len(way) > 2:
                yield way
            elif cell in robot_in and cell > way[0] and cell not in way:
                yield from rings((*way, cell))

    for robot, cell in enumerate(cells):
        for to in near[cell]:
            if to not in robot_in:
                yield *cells[:robot], to, *cells[robot + 1 :]
        for ring in rings((cell,)):
            after = dict(zip(ring, (*ring[1:], ring[0]), strict=True))
            yield tuple(after.get(each, each) for each in cells)


def reached_from(graph: Graph, starts: Cells) -> set[Cells]:
    cells = graph.layout.open_cells.tolist()
    near = {
        cell: [to for to in graph.neighbours[cell, :4].tolist() if to != CLOSED] for cell in cells
    }
    reached, stack = {starts}, [starts]
    while stack:
        new = set(next_cells(near, stack.pop())) - reached
        reached |= new
        stack += new
    return reached


def is_proved(problem: Problem) -> bool:
    try:
        check_solvable(problem)
    except PlanError:
        return True
    return False


def test_all_unsolvable_problems_of_small_floors_are_proved_so_and_no_others() -> None:
    stream, counts = np.random.default_rng(1), np.zeros(2, np.int64)
    while counts.min() < 50:
        shape = [(3, 3), (2, 5), (3, 4), (1, 6)][stream.integers(4)]
        tiles = np.where(stream.random(shape) < stream.choice([0.1, 0.3, 0.45]), "#", ".")
        layout = Layout(["".join(row) for row in tiles])
        cells = layout.open_cells
        if not 3 <= len(cells) <= 8:
            continue
        robots = int(stream.integers(2, min(len(cells), 5) + 1))
        starts, goals = (tuple(stream.permutation(cells)[:robots].tolist()) for _ in range(2))
        try:
            problem = Problem(Graph(layout), starts, goals)
        except PlanError:
            continue
        is_solvable = goals in reached_from(problem.graph, starts)
        assert is_proved(problem) != is_solvable, (layout, starts, goals)
        counts[int(is_solvable)] += 1


def test_full_rings_turn_but_their_order_stays() -> None:
    graph, ring = Graph(Layout(["...", ".#.", "..."])), [0, 1, 2, 5, 8, 7, 6, 3]
    for turned in range(8):
        goals = ring[turned:] + ring[:turned]
        assert not is_proved(Problem(graph, ring, goals))
        goals[0], goals[4] = goals[4], goals[0]
        assert is_proved(Problem(graph, ring, goals))


def test_no_planner_is_started_where_there_is_no_plan() -> None:
    def solve(problem: Problem, seconds: float) -> Plan:
        raise AssertionError

    corridor = Problem(Graph(Layout(["....", "#.##"])), [0, 1, 2], [2, 1, 0])
    expected = (
        "there is no plan: robots 0 and 1 cannot pass each other and the rest on the way to their "
        "goals"
    )
    with pytest.raises(PlanError, match=f"^{expected}$"):
        solve_checked("mine", solve, corridor, 1.0)


@pytest.mark.parametrize("length", [MAX_CELLS, MAX_CELLS + 1])
def test_proofs_are_looked_for_on_small_floors(length: int) -> None:
    corridor = Problem(Graph(Layout(["." * length])), [0, length - 1], [1, 0])
    assert is_proved(corridor) == (length == MAX_CELLS)


def test_the_limit_of_states_is_of_all_pairs_together(monkeypatch: pytest.MonkeyPatch) -> None:
    # Robots 0 and 1 can get to their goals; 0 and 2 cannot, since robot 3 would be between them.
    problem = Problem(Graph(Layout(["......"])), [0, 1, 2, 3], [0, 1, 3, 2])
    moves = PairMoves(problem.graph)
    sizes = [len(_reach(moves, moves.state(0, other, problem.starts), 999)) for other in (1, 2)]
    for most, is_enough in (sum(sizes), True), (sum(sizes) - 1, False):
        monkeypatch.setattr(solvable, "MAX_STATES", most)
        assert is_proved(problem) == is_enough
