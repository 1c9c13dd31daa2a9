"""PIBT: small cases by hand, crowds by the rules of the field."""

import numpy as np
import pytest

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.pibt import NOBODY, PIBT, pibt
from agents.mapf.planner import Situation
from agents.mapf.problem import Problem
from warehouse_core import Layout, random_layout

RING = Layout(["...", ".#.", "..."])


def next_cells(planner: PIBT, cells, goals, stays=(), closed=()) -> list[int]:
    """Return the next cells of robots, of which those in ``stays`` stay."""
    staying = np.isin(np.arange(len(cells)), stays)
    arrays = np.array(cells), np.array(goals), staying, np.array(closed, np.intp)
    return planner.next_cells(Situation(*arrays)).tolist()


def check_step(layout: Layout, before: list[int], after: list[int]) -> None:
    """Raise if robots meet, change places, jump or are in a wall."""
    assert len(set(after)) == len(after)
    moves = {(a, b) for a, b in zip(before, after, strict=True) if a != b}
    assert not {(b, a) for a, b in moves} & moves
    for here, there in zip(before, after, strict=True):
        assert layout.is_open(divmod(there, layout.width))
        (row, col), (next_row, next_col) = divmod(here, layout.width), divmod(there, layout.width)
        assert abs(row - next_row) + abs(col - next_col) <= 1


def test_a_ring_turns() -> None:
    """Nobody can move unless all do."""
    cells = [0, 1, 2, 5, 8, 7, 6, 3]
    planner = PIBT(Graph(RING))
    for _ in range(3):
        goals = [*cells[3:], *cells[:3]]
        after = next_cells(planner, cells, goals)
        assert after == [*cells[1:], cells[0]]


def test_two_that_meet_in_a_corridor_never_change_places() -> None:
    planner, cells, layout = PIBT(Graph(Layout(["...."]))), [1, 2], Layout(["...."])
    for _ in range(50):
        after = next_cells(planner, cells, [3, 0])
        check_step(layout, cells, after)
        assert after[0] < after[1]
        cells = after


def test_one_that_comes_pushes_one_that_is_at_its_goal() -> None:
    planner = PIBT(Graph(Layout(["...", "#.#"])))
    assert next_cells(planner, [0, 1], [2, 1])[0] == 1
    assert planner.pushers.tolist() == [NOBODY, 0]


def test_a_chain_of_three_thousand_is_pushed() -> None:
    length = 3_001
    planner = PIBT(Graph(Layout(["." * length])))
    cells = list(range(length - 1))
    after = next_cells(planner, cells, [length - 1, *cells[1:]])
    assert after == list(range(1, length))
    assert planner.pushers.tolist() == [NOBODY, *range(length - 2)]


def test_a_chain_that_is_blocked_at_its_end_stays() -> None:
    planner = PIBT(Graph(Layout(["." * 3_000])))
    cells = list(range(3_000))
    assert next_cells(planner, cells, [2_999, *cells[1:]]) == cells
    assert set(planner.pushers.tolist()) == {NOBODY}


def test_robots_that_stay_and_closed_cells_are_obeyed() -> None:
    planner = PIBT(Graph(Layout(["...", "..."])))
    assert next_cells(planner, [0, 1], [2, 5], stays=[0, 1]) == [0, 1]
    assert next_cells(planner, [0, 1], [2, 1], stays=[1])[0] != 1
    assert next_cells(planner, [0], [2], closed=[1, 3]) == [0]
    assert next_cells(planner, [0, 3], [2, 0], closed=[0, 1]) != [0, 0]


def test_a_robot_in_a_closed_cell_may_stay_there() -> None:
    planner = PIBT(Graph(Layout(["..."])))
    assert next_cells(planner, [0, 2], [0, 0], closed=[0, 1]) == [0, 2]


def test_goals_that_cannot_be_reached_or_are_shared_do_no_harm() -> None:
    layout = Layout(["..#.", "..#."])
    planner, cells = PIBT(Graph(layout)), [0, 1, 5]
    for _ in range(20):
        after = next_cells(planner, cells, [4, 4, 3])
        check_step(layout, cells, after)
        cells = after
    assert next_cells(planner, [0], [7]) == [0]
    assert next_cells(planner, [0], [2]) == [0]


def test_who_waited_longer_goes_first() -> None:
    """Both want the cell in the middle; the one that came from its goal later has to wait."""
    for seed in range(8):
        planner = PIBT(Graph(Layout(["...", "#.#"])), seed)
        next_cells(planner, [0, 2], [1, 2], stays=[0])
        assert next_cells(planner, [0, 2], [4, 4])[0] in {0, 1}
        planner.reset()
        next_cells(planner, [0, 2], [4, 2], stays=[0, 1])
        next_cells(planner, [0, 2], [4, 2], stays=[0, 1])
        assert next_cells(planner, [0, 2], [4, 4])[0] == 1


@pytest.mark.parametrize("wrong_way", [1, 5, 2.5])
@pytest.mark.parametrize("seed", range(6))
def test_crowds_move_by_the_rules_and_the_same_by_the_same_seed(
    wrong_way: float, seed: int
) -> None:
    layout, stream = random_layout(12, 14, 0.15, seed), np.random.default_rng(seed)
    graph = Graph(layout, lane_costs(layout, wrong_way))
    planners = [PIBT(graph, seed), PIBT(graph, seed)]
    cells = stream.permutation(layout.open_cells)[:60].tolist()
    goals = stream.choice(layout.open_cells, 60).tolist()
    for _ in range(60):
        stays = np.flatnonzero(stream.random(60) < 0.1).tolist()
        free = np.setdiff1d(layout.open_cells, cells)
        closed = stream.choice(free, 4).tolist()
        after, same = (next_cells(each, cells, goals, stays, closed) for each in planners)
        assert after == same
        check_step(layout, cells, after)
        assert [after[robot] for robot in stays] == [cells[robot] for robot in stays]
        assert not set(after) & set(closed)
        cells = after
        goals = [
            int(stream.choice(layout.open_cells)) if cell == goal else goal
            for cell, goal in zip(cells, goals, strict=True)
        ]


def test_after_a_reset_the_same_follows() -> None:
    layout = random_layout(10, 10, 0.1, 3)
    planner, cells = PIBT(Graph(layout), 7), layout.open_cells[:30].tolist()
    goals = layout.open_cells[-30:].tolist()
    first = [next_cells(planner, cells, goals) for _ in range(3)]
    planner.reset()
    assert [next_cells(planner, cells, goals) for _ in range(3)] == first


def test_robots_are_led_to_their_goals() -> None:
    layout = random_layout(16, 16, 0.1, 1)
    stream = np.random.default_rng(1)
    starts, goals = (stream.permutation(layout.open_cells)[:40].tolist() for _ in range(2))
    plan = pibt(Problem(Graph(layout), starts, goals), 10.0)
    assert (plan.cells[0].tolist(), plan.cells[-1].tolist()) == (starts, goals)
    for before, after in zip(plan.cells.tolist(), plan.cells[1:].tolist(), strict=False):
        check_step(layout, before, after)


def test_a_problem_that_it_does_not_solve_ends_in_time() -> None:
    with pytest.raises(PlanError, match=r"no plan after 0\.05 s"):
        pibt(Problem(Graph(Layout(["...."])), [1, 2], [2, 1]), 0.05)


def test_urgent_robots_go_first() -> None:
    corridor = Graph(Layout(["....."]))
    given = np.array([1, 2]), np.array([4, 0]), np.zeros(2, np.bool_), np.empty(0, np.intp)
    for urgent, after in ((0, [2, 3]), (1, [0, 1])):
        for seed in range(4):
            planner = PIBT(corridor, seed)
            planner.next_cells(Situation(*given))
            assert planner.next_cells(Situation(*given, np.array([urgent]))).tolist() == after


def test_priority_begins_anew_at_a_goal_and_not_when_the_goal_changes() -> None:
    corridor = Graph(Layout(["......."]))
    for seed in range(5):
        planner = PIBT(corridor, seed)
        next_cells(planner, [1, 5], [3, 5])
        assert next_cells(planner, [2, 3], [6, 0]) == [3, 4]
        planner.reset()
        next_cells(planner, [2, 5], [2, 6])
        assert next_cells(planner, [2, 3], [6, 0]) == [1, 2]
