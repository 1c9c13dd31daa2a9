"""The boxes of the walls cover exactly the walls, are few, and have a fixed order."""

from collections import Counter

from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Layout
from warehouse_physics.walls import wall_boxes


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """Generate a layout with random walls and at least one open cell."""
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


@settings(max_examples=50)
@given(layouts())
def test_boxes_cover_the_walls_and_a_ring_around_exactly_once(layout) -> None:
    wall_cells = {
        (row, col)
        for row in range(-1, layout.height + 1)
        for col in range(-1, layout.width + 1)
        if not layout.is_open((row, col))
    }
    boxes = wall_boxes(layout)
    assert covered(boxes) == dict.fromkeys(wall_cells, 1)
    runs = sum(len(line.replace(".", " ").split()) for line in layout.rows)
    assert len(boxes) <= 4 + runs
    # The order decides the last bits of motions: boxes are in the order of their lower edges.
    assert [box[3] for box in boxes[4:]] == sorted(box[3] for box in boxes[4:])
