import pytest
from matplotlib.figure import Figure

from warehouse_core.viz.axes.tiles import MIN_BOARDS, MIN_WAVES, OUTER, draw_tiles, outer_of

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


@pytest.mark.parametrize(
    ("rows", "outer"),
    [
        (["###", "#.#", "###"], OUTER),
        (["#?#", "#.#", "??#"], OUTER),
        (["###", "#.P", "###"], 0.0),
        (["#.#", "#.#", "###"], 0.0),
        (["##", "##"], 0.0),
    ],
)
def test_a_border_of_walls_is_not_shown_whole(rows: list[str], outer: float) -> None:
    assert outer_of([rows]) == outer
    assert outer_of([["###"] * 3, rows]) == outer
