import pytest
from matplotlib.figure import Figure

from warehouse_core.viz.axes.tiles import MIN_BOARDS, MIN_WAVES, draw_tiles

SHELF = ["....", ".##.", "...."]


@pytest.mark.parametrize(
    ("rows", "slippery", "least"), [(SHELF, [], MIN_BOARDS), (["..."] * 3, [(1, 1)], MIN_WAVES)]
)
def test_small_cells_have_no_texture(
    rows: list[str], slippery: list[tuple[int, int]], least: float
) -> None:
    def count(cell_points: float) -> int:
        return len(draw_tiles(Figure().add_subplot(), rows, cell_points, slippery))

    assert count(least) == count(least - 0.1) + 1
