import math

import pytest

from warehouse_core import DEFAULT_LAYOUT, Contact, Layout, Outcome
from warehouse_core.motion import grid as grid_motion_module
from warehouse_core.motion.grid import GridMotion, nominal_joules

STAY, NORTH, EAST, SOUTH, WEST = (0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)
HALL = Layout(["....."] * 5)


def started(*cells: tuple[int, int], cell_size: float = 1.0, layout: Layout = HALL) -> GridMotion:
    motion = GridMotion(cell_size)
    motion.reset(layout, cells, seed=None)
    return motion


def moved(motion: GridMotion, move: tuple[int, int], loaded: bool = False) -> Outcome:
    return motion.advance([move], [loaded])[0]


def test_a_free_move_takes_the_robot_to_the_next_cell() -> None:
    outcome = moved(started((2, 2)), SOUTH)
    assert (outcome.cell, outcome.blocked, outcome.contacts) == ((3, 2), False, ())
    assert outcome.path.tolist() == [[0, 2.5, 2.5, math.pi / 2], [1, 2.5, 3.5, math.pi / 2]]


def test_a_wall_stops_the_robot_and_costs_a_bump() -> None:
    outcome = moved(started((1, 1), layout=DEFAULT_LAYOUT), WEST)
    assert (outcome.cell, outcome.blocked) == ((1, 1), True)
    assert outcome.contacts == (Contact(0.5, 50.0, (1.0, 1.5), "wall"),)
    assert outcome.path[:, 1:3].tolist() == [[1.5, 1.5], [1.5, 1.5]]


def test_the_cost_of_a_move_follows_the_formula() -> None:
    rolling = 0.015 * 50 * 9.81
    assert nominal_joules(1.0, moving=False) == 20.0
    assert nominal_joules(1.0, moving=True) == pytest.approx(20 + 25 + rolling)
    assert nominal_joules(0.5, moving=True) == pytest.approx(20 + 6.25 + rolling / 2)


def test_every_action_takes_a_second_and_a_bump_costs_as_much_as_a_move() -> None:
    motion = started((0, 0))
    waiting, blocked, free = (moved(motion, move) for move in (STAY, NORTH, SOUTH))
    assert {outcome.seconds for outcome in (waiting, blocked, free)} == {1.0}
    assert waiting.joules < blocked.joules == free.joules


def test_positions_and_impulses_grow_with_the_cell() -> None:
    outcome = moved(started((0, 4), cell_size=0.5), EAST)
    assert outcome.path[0, 1:3].tolist() == [2.25, 0.25]
    assert outcome.contacts == (Contact(0.5, 25.0, (2.5, 0.25), "wall"),)


@pytest.mark.parametrize("cell_size", [0, math.nan, math.inf])
def test_a_cell_size_must_be_positive_and_finite(cell_size: float) -> None:
    with pytest.raises(ValueError, match="cell_size is"):
        GridMotion(cell_size)


def test_a_robot_starts_heading_east_and_keeps_its_heading_while_it_waits() -> None:
    motion = started((2, 2))
    assert moved(motion, STAY).path[0, 3] == 0
    moved(motion, NORTH)
    assert moved(motion, STAY).path[0, 3] == pytest.approx(-math.pi / 2)
    motion.reset(HALL, [(2, 2)], None)
    assert moved(motion, STAY).path[0, 3] == 0


def test_the_cache_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grid_motion_module, "MAX_CACHED", 3)
    motion = started((0, 0))
    for _ in range(5):
        for move in (EAST, SOUTH, WEST, NORTH):
            moved(motion, move)
            assert len(motion._lone) <= 3


def test_outcomes_are_equal_when_every_value_is() -> None:
    one, twin, other = (moved(started((2, 2)), move) for move in (EAST, EAST, WEST))
    assert one == twin
    assert not one != twin  # noqa: SIM202 - the operator itself is what is tested
    assert one != other
    assert one != one._replace(path=one.path + 1e-12)
    assert one != one._replace(joules=one.joules + 1)
    assert one != "an outcome"
    assert hash(one) == hash(twin)
