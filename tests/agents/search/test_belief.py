"""The belief of a robot: the cells that it has seen, and that all others are free."""

from agents.search.algorithms import breadth_first_search
from agents.search.belief import Belief, BeliefProblem
from warehouse_core import WarehouseEnv
from warehouse_core.world.tiles import WALL


def believed(view_radius: int = 1) -> tuple[Belief, WarehouseEnv]:
    env = WarehouseEnv(
        ["#####", "#P#D#", "#.#.#", "#...#", "#####"], (2, 1), view_radius=view_radius
    )
    belief = Belief()
    belief.look(env.observe())
    return belief, env


def test_the_cells_in_view_are_known() -> None:
    belief, env = believed()
    assert belief.known == {
        (row, col): WALL if env.grid[row][col] == WALL else "."
        for row in (1, 2, 3)
        for col in (0, 1, 2)
    }


def test_cells_outside_the_grid_are_walls() -> None:
    belief, _ = believed(view_radius=3)
    assert belief.known[-1, 1] == WALL
    assert not belief.is_free((-1, 1))


def test_cells_that_were_not_seen_are_free() -> None:
    belief, _ = believed()
    assert belief.is_free((77, -3))
    assert not belief.is_free((2, 2))


def test_a_bump_is_a_wall_only_if_the_cell_was_not_seen() -> None:
    belief, _ = believed()
    for cell in ((9, 9), (1, 1)):
        belief.bump(cell)
        assert belief.is_free(cell)  # one failure is no proof
        belief.bump(cell)
    assert not belief.is_free((9, 9))
    assert belief.is_free((1, 1))
    assert (9, 9) not in belief.known
    belief.bumps.clear()
    assert belief.is_free((9, 9))


def test_a_path_leads_through_unknown_cells_and_around_known_walls() -> None:
    belief, _ = believed()
    found = breadth_first_search(BeliefProblem(belief, (2, 1), (2, 3)))
    assert found.cost == 4  # below the wall, through cells that were not seen
    assert (2, 2) not in found.states


def test_the_search_ends_if_the_goal_is_walled_in() -> None:
    belief = Belief()
    for cell in ((4, 5), (6, 5), (5, 4), (5, 6)):
        belief.known[cell] = WALL
    assert not breadth_first_search(BeliefProblem(belief, (0, 0), (5, 5))).found
    assert not breadth_first_search(BeliefProblem(belief, (5, 5), (0, 0))).found


def test_a_path_may_lead_one_cell_beyond_the_known_ones() -> None:
    belief = Belief()
    for row in range(10):
        belief.known[row, 3] = WALL
    found = breadth_first_search(BeliefProblem(belief, (5, 0), (5, 6)))
    assert found.cost == 6 + 2 * 5
    assert {row for row, _ in found.states} <= set(range(-1, 11))
