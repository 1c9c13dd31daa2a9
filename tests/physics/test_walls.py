"""The boxes of the walls: exactly the walls, few of them, and always in the same order."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Layout, random_layout
from warehouse_core.world.tiles import WALL
from warehouse_physics.walls import wall_boxes


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """Draw a layout of any pattern with an open cell somewhere."""
    height, width = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    tiles = draw(st.lists(st.sampled_from("#."), min_size=height * width, max_size=height * width))
    tiles[draw(st.integers(0, height * width - 1))] = "."
    text = "".join(tiles)
    return Layout([text[row * width : (row + 1) * width] for row in range(height)])


def covered(boxes: list[tuple[int, int, int, int]]) -> Counter[tuple[int, int]]:
    """Return how many boxes cover each cell (row, column)."""
    return Counter(
        (row, col)
        for left, top, right, bottom in boxes
        for row in range(top, bottom)
        for col in range(left, right)
    )


@given(layouts())
def test_boxes_cover_the_walls_and_a_ring_around_once_each_and_nothing_else(layout) -> None:
    wall_cells = {
        (row, col)
        for row in range(-1, layout.height + 1)
        for col in range(-1, layout.width + 1)
        if not layout.is_open((row, col))
    }
    assert covered(wall_boxes(layout)) == dict.fromkeys(wall_cells, 1)


@given(layouts())
def test_there_are_no_more_boxes_than_runs_of_wall_in_the_rows(layout) -> None:
    runs = sum(len(line.replace(".", " ").split()) for line in layout.rows)
    assert len(wall_boxes(layout)) <= 4 + runs


def test_a_wall_along_rows_and_one_along_columns_are_a_box_each() -> None:
    boxes = wall_boxes(Layout(["#####", "#...#", "#...#", "#####"]))
    assert boxes[4:] == [(0, 0, 5, 1), (0, 1, 1, 3), (4, 1, 5, 3), (0, 3, 5, 4)]


def test_the_default_layout_takes_few_boxes() -> None:
    cells = sum(line.count(WALL) for line in DEFAULT_LAYOUT.rows)
    assert len(wall_boxes(DEFAULT_LAYOUT)) < cells / 2


def test_the_order_is_fixed() -> None:
    layout = random_layout(20, 20, 0.3, seed=1)
    again = Layout(list(layout.rows))
    assert wall_boxes(layout) == wall_boxes(again)
    inner = wall_boxes(layout)[4:]
    # A box is done where it ends, so lower ends come later, and from left to right among them.
    assert inner == sorted(inner, key=lambda box: box[3])
