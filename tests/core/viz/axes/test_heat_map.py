"""Where robots were blocked, and how often something happened in each cell."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from warehouse_core import FleetEnv, Layout
from warehouse_core.records import FleetEpisode, FleetRecorder
from warehouse_core.viz.axes.heat_map import TICK_ROOM, draw_heat, heat_map, held_up_cells

ROWS = ["P..##", "..#.D"]


@pytest.mark.parametrize(("cell_points", "every"), [(21, 1), (20.9, 2), (5, 5), (2.1, 10)])
def test_numbers_of_rows_and_columns_are_as_close_as_there_is_room(
    cell_points: float, every: int
) -> None:
    axes = Figure().add_subplot()
    draw_heat(axes, ["." * 40] * 40, np.ones((40, 40), np.int64), cell_points, 10)
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


def driven(*actions: list[str]) -> FleetEpisode:
    layout, starts = Layout(["...C.", "....."]), [(0, 1), (1, 4)]
    env = FleetEnv(layout, 2, orders=None, starts=starts, max_steps=20)
    recorder = FleetRecorder(env, seed=1)
    for each in actions:
        recorder.step(each)
    return recorder.episode


def test_waiting_being_blocked_and_turning_back_hold_robots_up() -> None:
    # Robot 0 waits, goes east, turns back, goes west; robot 1 is blocked by the border.
    episode = driven(["WAIT", "E"], ["E", "W"], ["W", "W"], ["W", "W"])
    assert held_up_cells(episode).tolist() == [[0, 1, 1, 0, 0], [0, 0, 0, 0, 1]]


def test_charging_and_ways_around_corners_do_not_hold_robots_up() -> None:
    episode = driven(["E", "W"], ["E", "W"], ["WAIT", "N"], ["S", "E"], ["W", "E"])
    assert held_up_cells(episode).sum() == 0
    assert held_up_cells(driven(*[["PICK", "DROP"]] * 3)).sum() == 0


def test_a_wait_between_two_moves_is_counted_once() -> None:
    episode = driven(["E", "W"], ["WAIT", "W"], ["W", "W"])
    assert held_up_cells(episode).tolist() == [[0, 0, 1, 0, 0], [0] * 5]
