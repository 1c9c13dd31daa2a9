"""What a robot believes: what it has seen, and that the rest is free."""

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


def test_it_is_what_is_in_view_at_the_place_where_it_is() -> None:
    belief, env = believed()
    assert belief.known == {
        (row, col): WALL if env.grid[row][col] == WALL else "."
        for row in (1, 2, 3)
        for col in (0, 1, 2)
    }


def test_what_lies_outside_the_grid_is_seen_as_a_wall() -> None:
    belief, _ = believed(view_radius=3)
    assert belief.known[-1, 1] == WALL
    assert not belief.is_free((-1, 1))


def test_what_has_not_been_seen_is_believed_to_be_free() -> None:
    belief, _ = believed()
    assert belief.is_free((77, -3))
    assert not belief.is_free((2, 2))


def test_a_bump_is_a_wall_only_where_nothing_was_seen() -> None:
    belief, _ = believed()
    for cell in ((9, 9), (1, 1)):
        belief.bump(cell)
        assert belief.is_free(cell)  # once is no proof
        belief.bump(cell)
    assert not belief.is_free((9, 9))
    assert belief.is_free((1, 1))
    assert (9, 9) not in belief.known
    belief.bumps.clear()
    assert belief.is_free((9, 9))


def test_a_way_leads_through_the_unknown_and_round_what_is_known() -> None:
    belief, _ = believed()
    found = breadth_first_search(BeliefProblem(belief, (2, 1), (2, 3)))
    assert found.cost == 4  # by the floor below the wall; nothing is known against it
    assert (2, 2) not in found.states


def test_the_search_ends_where_the_goal_is_walled_in_and_the_world_has_no_known_end() -> None:
    belief = Belief()
    for cell in ((4, 5), (6, 5), (5, 4), (5, 6)):
        belief.known[cell] = WALL
    assert not breadth_first_search(BeliefProblem(belief, (0, 0), (5, 5))).found
    assert not breadth_first_search(BeliefProblem(belief, (5, 5), (0, 0))).found


def test_one_cell_beyond_all_that_is_known_is_enough_to_get_round_it() -> None:
    belief = Belief()
    for row in range(10):
        belief.known[row, 3] = WALL
    found = breadth_first_search(BeliefProblem(belief, (5, 0), (5, 6)))
    assert found.cost == 6 + 2 * 5
    assert {row for row, _ in found.states} <= set(range(-1, 11))
