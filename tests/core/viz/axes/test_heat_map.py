"""Where robots were blocked, and how often something happened in each cell."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import COLORS, INK, PAPER, SHELF
from warehouse_core.viz.axes.heat_map import (
    MIN_SIZE,
    TICK_ROOM,
    draw_heat,
    heat_map,
)

ROWS = ["P..##", "..#.D"]
COUNTS = np.array([[0, 6, 1, 0, 0], [10, 0, 0, 7, 0]])


def heat_of(cell_points: float, rows: list[str] = ROWS, **options: Any) -> Any:
    """Return the axes of heat with cells of so many points, and the heat."""
    axes = Figure().add_subplot()
    return axes, draw_heat(axes, rows, COUNTS, cell_points, 10, **options)


def boxes_of(collection: Any) -> list[tuple[float, float, float, float]]:
    """Return left, top, right and bottom of each shape of a collection."""
    corners = [path.vertices for path in collection.get_paths()]
    return [(*each.min(axis=0), *each.max(axis=0)) for each in corners]


def test_cells_with_counts_have_heat_and_walls_are_drawn() -> None:
    axes, heat = heat_of(50)
    assert boxes_of(heat) == [(1, 0, 2, 1), (2, 0, 3, 1), (0, 1, 1, 2), (3, 1, 4, 2)]
    assert heat.get_array().tolist() == [6, 1, 10, 7]
    assert heat.get_clim() == (0, 10)
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, 5), (2, 0))
    walls = axes.collections[-1]
    assert boxes_of(walls) == [(3, 0, 5, 1), (2, 1, 3, 2)]
    assert tuple(walls.get_facecolor()[0][:3]) == SHELF
    grid = {tuple(map(tuple, line)) for line in axes.collections[0].get_segments()}
    assert grid == {((x, 0), (x, 2)) for x in range(6)} | {((0, y), (5, y)) for y in range(3)}


def test_counts_are_written_into_the_middle_of_their_cells_light_on_dark() -> None:
    axes, _ = heat_of(50)
    words = {
        text.get_text(): (text.get_position(), text.get_color(), text.get_fontsize())
        for text in axes.texts
    }
    assert {number: color for number, (_, color, _) in words.items()} == {
        "6": INK, "1": INK, "10": PAPER, "7": PAPER
    }  # fmt: skip
    for number, ((x, y), _, size) in words.items():
        row, col = np.argwhere(int(number) == COUNTS)[0]
        assert (x, y) == pytest.approx((col + 0.5, row + 0.5), abs=0.1)
        assert MIN_SIZE <= size < 0.6 * 50
        assert 0.7 * size * len(number) < 50, "it fits into its cell"
    assert not heat_of(50, digits=False)[0].texts
    assert not heat_of(20)[0].texts, "they would be too small"


@pytest.mark.parametrize(("cell_points", "every"), [(21, 1), (20.9, 2), (5, 5), (2.1, 10)])
def test_numbers_of_rows_and_columns_are_as_close_as_there_is_room(
    cell_points: float, every: int
) -> None:
    axes, _ = heat_of(cell_points, rows=["." * 40] * 40)
    assert every * cell_points >= TICK_ROOM
    for axis in (axes.xaxis, axes.yaxis):
        labels = [label.get_text() for label in axis.get_ticklabels()]
        assert labels == [str(number) for number in range(0, 40, every)]
        assert list(axis.get_ticklocs()) == [int(label) + 0.5 for label in labels]


@pytest.mark.parametrize("rows", [ROWS, ["." * 40], ["."] * 40, ["."]])
@pytest.mark.parametrize("panels", [1, 2, 3])
def test_panels_are_in_lines_of_two_with_a_bar_each(rows: list[str], panels: int) -> None:
    counts = np.ones((len(rows), len(rows[0])), np.int64)
    figure = heat_map(rows, {f"panel {number}": counts for number in range(panels)})
    wide, high = figure.get_size_inches()
    maps, bars = figure.axes[::2], figure.axes[1::2]
    assert [axes.get_title(loc="left") for axes in maps] == [f"panel {n}" for n in range(panels)]
    boxes = [axes.get_position() for axes in maps]
    for box, bar in zip(boxes, (axes.get_position() for axes in bars), strict=True):
        assert box.width * wide / len(rows[0]) == pytest.approx(box.height * high / len(rows))
        assert box.x1 < bar.x0 < bar.x1 < 1
        assert (bar.y0, bar.y1) == pytest.approx((box.y0, box.y1))
        assert box.x0 * wide > 0.2, "there is room for the numbers of rows"
        assert box.y0 * high > 0.2
        assert (1 - box.y1) * high > 0.3, "and for a title"
    if panels > 1:
        assert boxes[0].y0 == boxes[1].y0
        assert bars[0].get_position().x1 < boxes[1].x0
    if panels > 2:
        assert boxes[2].x0 == boxes[0].x0
        assert (boxes[0].y0 - boxes[2].y1) * high > 0.5
    assert wide <= 9.7


def test_stations_have_a_frame_and_their_letter() -> None:
    axes = heat_map(ROWS, {"": COUNTS}, with_stations=True).axes[0]
    frames = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    assert [frame.get_bbox().bounds for frame in frames] == [(0, 0, 1, 1), (4, 1, 1, 1)]
    colors: list[Any] = [frame.get_edgecolor() for frame in frames]
    assert [tuple(color[:3]) for color in colors] == [COLORS["P"], COLORS["D"]]
    assert not any(frame.get_fill() for frame in frames)
    letters = {text.get_text(): text.get_position() for text in axes.texts[-2:]}
    assert letters == {"P": (0.5, 0), "D": (4.5, 1)}
    plain = heat_map(ROWS, {"": COUNTS}).axes[0]
    assert not plain.patches
