"""The belief of a robot: the cells that it has seen; all others are assumed to be free."""

import math
import random
from typing import Any

from agents.search.algorithms import breadth_first_search
from agents.search.belief import Belief, BeliefProblem
from warehouse_core import Cell, WarehouseEnv
from warehouse_core.world.tiles import WALL


def believed(view_radius: int = 1) -> tuple[Belief, WarehouseEnv]:
    env = WarehouseEnv(
        ["#####", "#P#D#", "#.#.#", "#...#", "#####"], (2, 1), view_radius=view_radius
    )
    belief = Belief()
    belief.look(env.observe())
    return belief, env


def see(belief: Belief, cell: Cell, tile: str) -> None:
    """Add one cell."""
    observation: Any = {"robot_pos": cell, "local_grid": [tile]}
    belief.look(observation)


def test_cells_outside_the_grid_are_walls_and_unseen_cells_are_assumed_to_be_free() -> None:
    belief, _ = believed(view_radius=3)
    assert belief.known[-1, 1] == WALL
    assert not belief.is_free((-1, 1))
    assert belief.is_free((77, -3))
    assert not belief.is_free((2, 2))


def test_a_cell_is_a_wall_after_two_bumps_unless_it_was_seen() -> None:
    belief, _ = believed()
    for cell in ((9, 9), (1, 1)):
        belief.bump(cell)
        assert belief.is_free(cell)  # one bump is not enough
        belief.bump(cell)
    assert not belief.is_free((9, 9))
    assert belief.is_free((1, 1))
    assert (9, 9) not in belief.known
    belief.forget_bumps()
    assert belief.is_free((9, 9))


def test_a_path_leads_through_unknown_cells_and_around_known_walls() -> None:
    belief, _ = believed()
    found = breadth_first_search(BeliefProblem(belief, (2, 1), (2, 3)))
    assert found.cost == 4  # below the wall, through cells that were not seen
    assert (2, 2) not in found.states


def test_a_path_may_lead_around_walls_that_were_not_seen() -> None:
    """The bumps are further out than all cells seen, and so is the only path."""
    belief = Belief()
    see(belief, (5, 0), ".")
    for row in range(10):
        for _ in range(2):
            belief.bump((row, 3))
    found = breadth_first_search(BeliefProblem(belief, (5, 0), (5, 6)))
    assert found.cost == 6 + 2 * 5
    belief.forget_bumps()
    assert breadth_first_search(BeliefProblem(belief, (5, 0), (5, 6))).cost == 6


def test_each_search_gives_the_same_cost_as_with_a_new_belief() -> None:
    """Moves that have been computed are computed again where a wall is found or forgotten."""
    stream, belief, fewest = random.Random(1), Belief(), set()
    for _ in range(150):
        cell = stream.randrange(6), stream.randrange(6)
        if stream.random() < 0.5:
            belief.bump(cell)
            belief.bump(cell)
        else:
            see(belief, cell, stream.choice(".#"))
        if stream.random() < 0.05:
            belief.forget_bumps()
        new = Belief()
        new.known, new.bumps = belief.known, belief.bumps
        new.include(*belief.known, *belief.bumps)
        start, goal = (divmod(stream.randrange(36), 6) for _ in range(2))
        old, fresh = (BeliefProblem(each, start, goal) for each in (belief, new))
        assert breadth_first_search(old).cost == breadth_first_search(fresh).cost
        fewest.add(breadth_first_search(old).cost)
    assert {2, 12, math.inf} <= fewest
