import random

import pytest
from helpers.crowds import (
    CASES,
    EAST,
    LINES,
    NORTH,
    SOUTH,
    STAY,
    WEST,
    array_stops,
    check_crowds,
    targets_of,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Cell, Layout
from warehouse_core.motion.traffic import MAX_SMALL_FRONT, find_stops

HALL = Layout(["......"] * 6)


@pytest.mark.parametrize(("cells", "moves", "stops"), CASES.values(), ids=CASES)
def test_stops_follow_the_table(form, cells, moves, stops) -> None:
    assert find_stops(HALL, cells, targets_of(cells, moves)) == stops
    assert array_stops(HALL, cells, moves) == stops


@st.composite
def traffic(draw: st.DrawFn) -> tuple[Layout, list[Cell], list[Cell]]:
    rows = draw(st.lists(st.text(".....#", min_size=4, max_size=4), min_size=4, max_size=4))
    layout = Layout(["....", *rows])
    everywhere = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    cells = draw(st.permutations(everywhere))[: draw(st.integers(1, 8))]
    moves = [draw(st.sampled_from([STAY, NORTH, EAST, SOUTH, WEST])) for _ in cells]
    return layout, cells, moves


@settings(max_examples=60)
@given(traffic(), st.integers(0, 99))
def test_stops_do_not_depend_on_the_order_of_the_robots(scene, seed) -> None:
    (layout, cells, moves), stream = scene, random.Random(seed)
    targets = targets_of(cells, moves)
    stops = find_stops(layout, cells, targets)
    order = stream.sample(range(len(cells)), len(cells))
    shuffled = find_stops(layout, [cells[i] for i in order], [targets[i] for i in order])
    assert [stop is None for stop in shuffled] == [stops[i] is None for i in order]


def test_all_forms_follow_the_table_in_crowds(form: str) -> None:
    lines = check_crowds(20_000)
    assert min(lines[line] for line in LINES) > 100, lines


@pytest.mark.parametrize(
    ("queues", "length"), [(1, 3000), (MAX_SMALL_FRONT + 1, 9)], ids=["one", "many"]
)
def test_queues(queues: int, length: int) -> None:
    """All queues end in the east. Only the queue of the first row has a free cell ahead."""
    layout = Layout(["." * (length + 1), *["." * length + "#"] * queues])
    cells = [(row, col) for row in range(queues + 1) for col in range(length)]
    stream = random.Random(0)
    stream.shuffle(cells)
    robot_in = {cell: robot for robot, cell in enumerate(cells)}
    expected = [
        None if row == 0 else "wall" if col == length - 1 else robot_in[row, col + 1]
        for row, col in cells
    ]
    moves = [EAST] * len(cells)
    assert find_stops(layout, cells, targets_of(cells, moves)) == expected
    assert array_stops(layout, cells, moves) == expected
