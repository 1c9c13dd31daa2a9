"""Heat maps of where robots get stuck: the counts and the picture."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.results_files import row
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.reports.figures import SHEETS, Sheet, stuck_cells, stuck_heat_map
from warehouse_core import DEFAULT_LAYOUT, random_layout
from warehouse_core.records.failure_modes import MODES
from warehouse_core.render.palette import COLORS, SHELF
from warehouse_core.viz.axes.heat_map import HEAT

ROWS = ("######", "#....#", "#..#.#", "#....#", "######")
LARGE = random_layout(20, 40, 0.2, 3).rows
TALL = ("#" * 4, *["#.P#", "#D.#"] * 20, "#" * 4)


def counts(*places: tuple[int, int, int], rows: tuple[str, ...] = ROWS) -> NDArray[np.int64]:
    grid = np.zeros((len(rows), len(rows[0])), dtype=np.int64)
    for at_row, col, count in places:
        grid[at_row, col] = count
    return grid


def panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_title(loc="left")]


def written(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def color_in(figure: Figure, axes: Axes, x: float, y: float) -> NDArray[np.float64]:
    """Return the colour, 0..1, at a position in cells."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    across, up = axes.transData.transform((x, y))
    return pixels[pixels.shape[0] - 1 - int(up), int(across), :3] / 255


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "r.sqlite") as opened:
        yield opened


def test_episodes_are_counted_where_they_were_stuck(store: Store) -> None:
    first, second, other = (store.case_id(make_case({"memory": m})) for m in (1, 2, 3))
    cells = {"wandering": [(1, 2), (1, 2), (3, 3)], "unreachable": [(1, 1)], "delivered": [(2, 2)]}
    rows = [
        row(0, mode, row=cell[0], col=cell[1]) for mode, found in cells.items() for cell in found
    ]
    store.add(first, [each._replace(seed=seed) for seed, each in enumerate(rows)])
    store.add(second, [row(0, "wandering", row=1, col=2)])
    store.add(other, [row(0, "wandering"), row(1, "stalled")])
    stuck = stuck_cells(store, DEFAULT_LAYOUT.rows, [first, second])
    assert list(stuck) == ["unreachable", "wandering"]
    assert stuck["wandering"].shape == (7, 12)
    assert stuck["wandering"][1, 2] == 3
    assert stuck["wandering"][3, 3] == 1
    assert stuck["wandering"].sum() == 4
    assert stuck["unreachable"].sum() == stuck["unreachable"][1, 1] == 1


def test_modes_are_in_the_order_of_definition(store: Store) -> None:
    case_id = store.case_id(make_case({}))
    store.add(case_id, [row(99)])
    assert stuck_cells(store, DEFAULT_LAYOUT.rows, [case_id]) == {}, "without failures"
    store.add(case_id, [row(n, mode) for n, mode in enumerate(reversed(MODES))])
    assert tuple(stuck_cells(store, DEFAULT_LAYOUT.rows, [case_id])) == MODES[1:]


def test_a_panel_has_its_mode_its_count_its_share_and_its_own_scale() -> None:
    stuck = {"wandering": counts((1, 2, 900), (3, 3, 100)), "stalled": counts((1, 1, 1))}
    figure = stuck_heat_map(ROWS, stuck, 4000)
    titles = [axes.get_title(loc="left") for axes in panels(figure)]
    assert titles == ["wandering: 1,000 (25.0%)", "stalled: 1 (0.0%)"]
    first, second = panels(figure)
    hottest = [color_in(figure, first, 2.1, 1.8), color_in(figure, second, 1.1, 1.8)]
    np.testing.assert_allclose(hottest, [HEAT(1.0)[:3]] * 2, atol=0.01)


def test_more_episodes_have_a_hotter_colour_and_none_the_colour_of_the_floor() -> None:
    figure = stuck_heat_map(ROWS, {"wandering": counts((1, 2, 100), (3, 3, 10))}, 200)
    [axes] = panels(figure)
    hot, warm = (color_in(figure, axes, x, y) for x, y in ((2.1, 1.8), (3.1, 3.8)))
    np.testing.assert_allclose(hot, HEAT(1.0)[:3], atol=0.01)
    np.testing.assert_allclose(warm, HEAT(0.1)[:3], atol=0.02)
    assert hot.sum() < warm.sum()
    np.testing.assert_allclose(color_in(figure, axes, 3.5, 2.5), SHELF, atol=0.01)
    floor = color_in(figure, axes, 1.5, 2.5)
    np.testing.assert_allclose(floor, COLORS["."], atol=0.01)
    assert floor.sum() > warm.sum()


def test_only_large_cells_show_their_number() -> None:
    [axes] = panels(stuck_heat_map(ROWS, {"wandering": counts((1, 2, 41), (3, 4, 7))}, 99))
    assert sorted(written(axes)) == ["41", "7"]
    [axes] = panels(stuck_heat_map(LARGE, {"wandering": counts((1, 2, 41), rows=LARGE)}, 99))
    assert written(axes) == []


@pytest.mark.parametrize(
    ("rows", "count"), [(ROWS, 1), (LARGE, 4), (TALL, 5), (ROWS, len(MODES) - 1)]
)
@pytest.mark.parametrize("sheet", SHEETS)
def test_panels_neither_overlap_nor_leave_the_figure(
    rows: tuple[str, ...], count: int, sheet: Sheet
) -> None:
    stuck = {mode: counts((1, 1, 1_000_000), rows=rows) for mode in MODES[1 : count + 1]}
    figure = stuck_heat_map(rows, stuck, 1_000_000, sheet)
    assert figure.get_figwidth() <= sheet.width + 1e-9
    FigureCanvasAgg(figure).draw()
    boxes = [axes.get_tightbbox().frozen() for axes in figure.axes]
    assert len(boxes) == 2 * count, "each panel has its bar"
    whole = [Bbox.union(boxes[n : n + 2]) for n in range(0, 2 * count, 2)]
    for number, box in enumerate(whole):
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= figure.bbox.width
        assert box.y1 <= figure.bbox.height
        assert not any(box.overlaps(other) for other in whole[:number])


@pytest.mark.parametrize("small", [False, True])
def test_stations_of_the_layout_have_their_letters_on_top_and_a_frame(small: bool) -> None:
    rows = ["#" * 6, "#P...#", "#...D#", "#" * 6]
    if small:
        rows = [line + "#" * 60 for line in rows]
    stuck = {"wandering": counts((1, 1, 3), rows=tuple(rows))}
    [axes] = panels(stuck_heat_map(rows, stuck, 9, with_stations=True))
    letters = {text.get_text(): text.get_position() for text in axes.texts}
    assert {name: letters[name] for name in "PD"} == {"P": (1.5, 1), "D": (4.5, 2)}
    frames = {frame.get_xy(): frame.get_edgecolor()[:3] for frame in axes.patches}
    assert frames == {(1, 1): COLORS["P"], (4, 2): COLORS["D"]}
    [plain] = panels(stuck_heat_map(rows, stuck, 9))
    assert len(plain.patches) == 0


def test_numbers_of_rows_and_columns_do_not_overlap() -> None:
    rows = ("#" * 700, "#" + "." * 698 + "#", "#" * 700)
    figure = stuck_heat_map(rows, {"wandering": counts((1, 2, 41), rows=rows)}, 99)
    [axes] = panels(figure)
    FigureCanvasAgg(figure).draw()
    boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
    assert len(boxes) > 5
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))


def test_cells_are_square() -> None:
    for rows in (ROWS, LARGE):
        figure = stuck_heat_map(rows, {"wandering": counts((1, 1, 3), rows=rows)}, 10)
        [axes] = panels(figure)
        box = axes.get_window_extent()
        assert box.width / len(rows[0]) == pytest.approx(box.height / len(rows))
