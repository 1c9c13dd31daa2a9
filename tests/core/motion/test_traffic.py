import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Cell, Layout
from warehouse_core.motion.traffic import Stop, find_stops
from warehouse_core.world.tiles import moved

HALL = Layout(["......"] * 6)
STAY, NORTH, EAST, SOUTH, WEST = (0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)


def targets_of(cells: list[Cell], moves: list[Cell]) -> list[Cell]:
    return [moved(cell, move) for cell, move in zip(cells, moves, strict=True)]


@pytest.mark.parametrize(
    ("cells", "moves", "stops"),
    [
        pytest.param([(2, 2)], [STAY], [None], id="waiting"),
        pytest.param([(2, 2)], [EAST], [None], id="free"),
        pytest.param([(0, 0)], [NORTH], ["wall"], id="wall"),
        pytest.param([(2, 1), (2, 3)], [EAST, WEST], [1, 0], id="same target"),
        pytest.param([(2, 1), (1, 2), (2, 3)], [EAST, SOUTH, WEST], [1, 0, 0], id="three at one"),
        pytest.param([(2, 2), (2, 3)], [EAST, WEST], [1, 0], id="head-on"),
        pytest.param([(2, 2), (2, 3)], [EAST, STAY], [1, None], id="occupied by a waiting robot"),
        pytest.param(
            [(2, 2), (2, 4), (2, 5)], [EAST, EAST, EAST], [None, 2, "wall"], id="queue at a wall"
        ),
        pytest.param([(2, 5), (2, 4), (2, 3)], [EAST] * 3, ["wall", 0, 1], id="spreads backwards"),
        pytest.param(
            [(2, 1), (2, 2), (2, 3)], [EAST, EAST, WEST], [2, 2, 0], id="same target goes first"
        ),
        pytest.param(
            [(2, 1), (2, 2), (2, 3), (2, 4)],
            [EAST, STAY, STAY, WEST],
            [1, None, None, 2],
            id="occupied from both sides",
        ),
        pytest.param([(2, 1), (2, 2), (2, 3)], [EAST] * 3, [None] * 3, id="following"),
        pytest.param(
            [(2, 2), (2, 3), (3, 3), (3, 2)], [EAST, SOUTH, WEST, NORTH], [None] * 4, id="cycle"
        ),
        pytest.param(
            [(2, 2), (2, 3), (3, 3), (3, 2), (1, 3)],
            [EAST, SOUTH, WEST, NORTH, SOUTH],
            [4, 2, 3, 0, 0],
            id="a fifth robot stops the cycle",
        ),
    ],
)
def test_stops_follow_the_table(cells: list[Cell], moves: list[Cell], stops: list[Stop]) -> None:
    assert find_stops(HALL, cells, targets_of(cells, moves)) == stops


def can_move(robot: int, layout: Layout, cells: list[Cell], targets: list[Cell]) -> bool:
    """Return whether a robot moves, by following the chain of robots ahead of it."""
    start, first = robot, True
    while first or robot != start:
        first = False
        if targets[robot] == cells[robot] or not layout.is_open(targets[robot]):
            return False
        if targets.count(targets[robot]) > 1 + (targets[robot] in waiting(cells, targets)):
            return False
        if targets[robot] not in cells:
            return True
        ahead = cells.index(targets[robot])
        if targets[ahead] == cells[robot]:
            return False
        robot = ahead
    return True


def waiting(cells: list[Cell], targets: list[Cell]) -> set[Cell]:
    return {cell for cell, target in zip(cells, targets, strict=True) if cell == target}


@st.composite
def traffic(draw: st.DrawFn) -> tuple[Layout, list[Cell], list[Cell]]:
    rows = draw(st.lists(st.text(".....#", min_size=4, max_size=4), min_size=4, max_size=4))
    layout = Layout(["....", *rows])
    everywhere = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    cells = draw(st.permutations(everywhere))[: draw(st.integers(1, 8))]
    moves = [draw(st.sampled_from([STAY, NORTH, EAST, SOUTH, WEST])) for _ in cells]
    return layout, cells, targets_of(cells, moves)


@settings(max_examples=60)
@given(traffic(), st.randoms(use_true_random=False))
def test_stops_are_consistent_in_any_traffic(
    scene: tuple[Layout, list[Cell], list[Cell]], stream: random.Random
) -> None:
    layout, cells, targets = scene
    stops = find_stops(layout, cells, targets)
    for robot, stop in enumerate(stops):
        moves = stop is None and targets[robot] != cells[robot]
        assert moves == can_move(robot, layout, cells, targets)
        assert (stop == "wall") == (not layout.is_open(targets[robot]))
        if isinstance(stop, int):
            assert stop != robot
            assert targets[robot] in (cells[stop], targets[stop])
    ends = [
        target if stop is None else cell
        for cell, target, stop in zip(cells, targets, stops, strict=True)
    ]
    assert len(set(ends)) == len(ends), "no two robots end in one cell"
    order = stream.sample(range(len(cells)), len(cells))
    shuffled = find_stops(layout, [cells[i] for i in order], [targets[i] for i in order])
    assert [stop is None for stop in shuffled] == [stops[i] is None for i in order]
