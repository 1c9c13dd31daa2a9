"""The figures of a report: points, intervals, lines, bars, labels, captions and dark colours."""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.results_files import OFF, ON, Cases, experiment_of, hall, outcomes, row
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from matplotlib.typing import ColorType
from numpy.typing import NDArray

from agents.lab.experiments.case import make_case
from agents.lab.experiments.plan import make_plan
from agents.lab.experiments.store import Store
from agents.lab.reports import figures as figures_module
from agents.lab.reports.design import make_design
from agents.lab.reports.figures import (
    DARK,
    MAX_MAPS,
    MODE_COLORS,
    PHONE,
    SHEETS,
    WIDE,
    DesignPoints,
    PaperSize,
    Picture,
    draw_legend,
    fitting,
    ink_on,
    make_panels,
    measure_figure,
    modes_figure,
    pictures,
    roles_of,
    stuck_cells,
    stuck_heat_map,
    themed_svg,
)
from agents.lab.reports.results import STEPS, SUCCESS, Experiment
from warehouse_core import DEFAULT_LAYOUT, random_layout
from warehouse_core.records.failure_modes import FLEET_MODES, MODES
from warehouse_core.render.palette import COLORS, INK, PAPER
from warehouse_core.render.palette import SERIES as LINES
from warehouse_core.viz.axes.heat_map import HEAT, ink_of_heat
from warehouse_core.viz.figure import SceneFigure, save_svg

STYLE = re.compile(r"<style>@media \(prefers-color-scheme:dark\)\{(.*?)\}</style>")


def roles(**choices: Any) -> list[Any]:
    found = roles_of(make_design(dict(enumerate(make_plan(choices, 1, 0).cases))))
    return [factor.name if factor else None for factor in found[:3]] + [
        factor.name for factor in found.pooled
    ]


@pytest.fixture
def experiment() -> Iterator[Experiment]:
    """Yield results of three batteries with escape and of two without."""
    cases = [
        ({"battery": battery, "escape": escape}, outcomes(words))
        for battery, escape, words in (
            (20, True, "dwww"), (60, True, "ddww"), (200, True, "dddw"),
            (20, False, "oooo"), (200, False, "dooo"),
        )
    ]  # fmt: skip
    with experiment_of(cases) as opened:
        yield opened


def chart_of(experiment: Experiment) -> DesignPoints:
    return DesignPoints(experiment, experiment.design)


def draw(experiment: Experiment, *, modes: bool = False) -> SceneFigure:
    if modes:
        return modes_figure(chart_of(experiment), "Modes")
    figure = measure_figure(chart_of(experiment), "Success", SUCCESS)
    assert figure is not None
    return figure


def middles(axes: Axes) -> list[tuple[list[float], list[float]]]:
    """Return the x and y values of the points of each line."""
    lines = [each.lines[0] for each in axes.containers]
    return [
        (np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist())
        for line in lines
    ]


def test_the_ordered_factor_with_the_most_values_is_on_the_axis() -> None:
    assert roles(battery=[20, 40, 60], escape=[True, False]) == ["battery", "escape", None]
    assert roles(memory=[2, 5], battery=[1, 2, 3], escape=[True, False]) == [
        "battery", "escape", "memory",
    ]  # fmt: skip
    assert roles(layout="random", size=["7x12", "9x9"], battery=[1, 2, 3])[0] == "battery"
    assert roles(escape=[True, False])[:2] == ["escape", None]
    assert roles() == [None, None, None]


def test_a_factor_with_too_many_values_for_colours_and_panels_is_pooled() -> None:
    found = roles(battery={"from": 1, "to": 30, "step": 1}, view_radius=[*range(9)], memory=[1, 2])
    assert found == ["battery", "memory", None, "view_radius"]


def test_points_and_their_intervals_are_at_the_values_of_the_data(experiment: Experiment) -> None:
    [axes] = draw(experiment).axes
    (first_x, first_y), (second_x, second_y) = middles(axes)
    assert first_y == [0.25, 0.5, 0.75]
    assert second_y == [0.0, 0.25]
    assert first_x == pytest.approx([0, 40, 180], abs=2)
    assert second_x == pytest.approx([0, 180], abs=2)
    assert first_x[0] < second_x[0]  # so that neither interval hides the other
    bars = axes.containers[0].lines[2][0].get_segments()
    results = experiment.results(1)
    assert bars[0][:, 1].tolist() == pytest.approx(results.main[1:])


def test_a_case_that_does_not_depend_on_the_axis_is_a_horizontal_line() -> None:
    cases = [
        ({"memory": 2}, outcomes("dw")),
        ({"memory": 9}, outcomes("dd")),
        ({"escape": False}, outcomes("dooo")),
    ]
    with experiment_of(cases) as experiment:
        figure = draw(experiment)
    [axes] = figure.axes
    [line] = [each for each in axes.lines if each.get_linestyle() == "--"]
    assert np.asarray(line.get_ydata()).tolist() == [0.25, 0.25]
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["escape on", "escape off"]


def test_without_deliveries_or_differences_there_is_no_chart_of_a_measure() -> None:
    cases = [({"battery": battery}, outcomes("ww")) for battery in (1, 2)]
    with experiment_of(cases) as experiment:
        assert measure_figure(chart_of(experiment), "", STEPS) is None

    with experiment_of([({}, outcomes("dw"))]) as experiment:
        assert measure_figure(chart_of(experiment), "", SUCCESS) is None
        [axes] = modes_figure(chart_of(experiment), "").axes
        assert [label.get_text() for label in axes.get_xticklabels()] == ["all episodes"]


def test_stacked_bars_add_up_to_1(experiment: Experiment) -> None:
    on, off = draw(experiment, modes=True).axes
    assert (on.get_title(loc="left"), off.get_title(loc="left")) == ("escape on", "escape off")
    heights = [
        (round(bar.get_x() + 0.4), bar.get_y(), bar.get_height())
        for group in on.containers
        for bar in group
    ]
    assert heights == [
        (0, 0, 0.25), (0, 0.25, 0.75), (1, 0, 0.5), (1, 0.5, 0.5), (2, 0, 0.75), (2, 0.75, 0.25),
    ]  # fmt: skip
    assert [label.get_text() for label in on.get_xticklabels()] == ["20", "60", "200"]
    assert [label.get_text() for label in off.get_xticklabels()] == ["20", "200"]


def test_each_mode_has_its_own_colour_and_a_name_in_the_legend(experiment: Experiment) -> None:
    figure = draw(experiment, modes=True)
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "delivered",
        "oscillation",
        "wandering",
    ]
    assert set(MODE_COLORS) == {*MODES, *FLEET_MODES}
    for modes in (MODES, FLEET_MODES):
        assert len({MODE_COLORS[mode] for mode in modes}) == len(modes)


def test_long_names_do_not_overlap(tmp_path: Path) -> None:
    files = [tmp_path / f"{'a very long name of a hall' * 3} {number}.txt" for number in range(5)]
    for file in files:
        file.write_text("#####\n#P.D#\n#####")
    cases = [({"layout": str(file)}, outcomes("dw")) for file in files]
    with experiment_of(cases) as experiment:
        for figure in (draw(experiment), draw(experiment, modes=True)):
            figure.pixels()
            labels = [label.get_window_extent() for label in figure.axes[0].get_xticklabels()]
            assert len(labels) == 5
            assert all(one.x1 < other.x0 for one, other in pairwise(labels))
            names = [label.get_text() for label in figure.axes[0].get_xticklabels()]
            assert len(set(names)) == 5


def test_pooled_cases_are_one_point() -> None:
    cases = [
        ({"battery": battery, "view_radius": radius}, outcomes("dw" if radius else "dd"))
        for battery in range(1, 12)
        for radius in range(9)
    ]
    with experiment_of(cases) as experiment:
        [axes] = draw(experiment).axes
    [(_, shares)] = middles(axes)
    assert shares == [pytest.approx(10 / 18)] * 11
    [whiskers] = axes.containers[0].lines[2]
    assert not any(len(segment) for segment in whiskers.get_segments())


def test_of_many_values_some_are_shown_at_equal_distances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figures_module, "MAX_POINTS", 20)
    cases = [
        ({"battery": battery, "escape": escape}, outcomes("dw"))
        for battery in range(1, 101)
        for escape in (True, False)
    ]
    with experiment_of(cases) as experiment:
        lines = middles(draw(experiment).axes[0])
        bars = draw(experiment, modes=True).axes[0]
    assert [len(places) for places, _ in lines] == [10, 10]
    assert [round(place) for place in lines[0][0]] == [-1, 10, 21, 32, 43, 54, 65, 76, 87, 98]
    assert len(bars.containers) == 20


@pytest.mark.parametrize("name", ["$x_{", "a_b^c$x$", "100%"])
def test_names_are_not_parsed_as_formulas(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text("#####\n#P.D#\n#####")
    places = [{"layout": name, "stations": "kept"} for name in ("default", str(file))]
    cases = [(place, outcomes("dw")) for place in places]
    with experiment_of(cases) as experiment:
        for figure in (draw(experiment), draw(experiment, modes=True)):
            figure.pixels()
            labels = [label.get_text() for label in figure.axes[0].get_xticklabels()]
            assert labels == ["default", name]


def test_everything_drawn_is_inside_the_figure(experiment: Experiment) -> None:
    for figure in (draw(experiment), draw(experiment, modes=True)):
        figure.pixels()
        drawn = figure.get_tightbbox(figure.canvas.get_renderer())
        width, height = figure.get_size_inches()
        assert drawn.x0 >= 0
        assert drawn.y0 >= 0
        assert drawn.x1 <= width
        assert drawn.y1 <= height


def test_a_share_is_written_into_the_middle_of_its_part_where_there_is_room() -> None:
    words = "d" * 11 + "o" + "w" * 2
    with experiment_of([({}, outcomes(words))]) as experiment:
        [axes] = modes_figure(chart_of(experiment), "").axes
    written = {text.get_text(): text.get_position() for text in axes.texts}
    assert written == {"79%": (0, pytest.approx(11 / 28)), "14%": (0, pytest.approx(13 / 14))}
    assert all((text.get_ha(), text.get_va()) == ("center",) * 2 for text in axes.texts)
    batteries = [({"battery": battery}, outcomes("d")) for battery in range(1, 13)]
    with experiment_of(batteries) as experiment:
        [wide], [phone] = (
            modes_figure(chart_of(experiment), "", sheet).axes for sheet in (WIDE, PHONE)
        )
    assert (len(wide.texts), len(phone.texts)) == (12, 0)


def test_names_that_are_too_long_lose_their_middles_and_then_some_are_left_out() -> None:
    assert fitting(["a" * 80], 81) == (1, ["a" * 80])
    assert fitting(["a" * 40 + "b" * 41], 81) == (1, ["a" * 40 + "…" + "b" * 39])
    assert fitting(["a" * 20 + "b" * 20, "c"], 42) == (1, ["a" * 10 + "…" + "b" * 9, "c"])
    assert fitting(["abcdefgh"] * 12, 108) == (1, ["abcdefgh"] * 12)
    assert fitting(["abcdefgh"] * 12, 107) == (1, ["abc…fgh"] * 12)
    assert fitting(["abcdefgh"] * 12, 40) == (2, ["ab…gh"] * 6)
    assert fitting([*map(str, range(40))], 81) == (4, [*map(str, range(0, 40, 4))])
    assert fitting(["abcdefgh"] * 3, 2) == (3, ["ab…gh"])


@pytest.mark.parametrize("letters", [20, 26, 80])
@pytest.mark.parametrize("names", [range(20, 260, 20), range(10**6, 10**6 + 9), range(1, 500)])
def test_names_along_an_axis_have_room_beside_each_other(names: range, letters: int) -> None:
    step, shown = fitting(list(map(str, names)), letters)
    assert 1 <= len(shown) == len(names[::step])
    assert sum(len(name) + 1 for name in shown) <= letters


@pytest.mark.parametrize(
    ("sheet", "count", "columns", "lines"), [(WIDE, 1, 1, 1), (WIDE, 4, 3, 2), (PHONE, 2, 1, 2)]
)
def test_panels_are_in_lines_below_a_title_and_a_legend(
    sheet: PaperSize, count: int, columns: int, lines: int
) -> None:
    keys = [f"a key {number}" for number in range(8)]
    panels = make_panels(sheet, "A title", count, keys)
    draw_legend(panels, [(key, Line2D([], [])) for key in keys])
    figure = panels.figure
    figure.pixels()
    boxes = [each.get_position() for each in panels.axes]
    assert len(figure.axes) == count
    assert len({round(box.x0, 6) for box in boxes}) == columns
    assert len({round(box.y0, 6) for box in boxes}) == lines
    [legend] = figure.legends
    below = legend.get_window_extent()
    assert below.x1 < figure.bbox.x1
    assert below.y0 > max(each.get_window_extent().y1 for each in panels.axes)
    title = figure._suptitle.get_window_extent()  # type: ignore[attr-defined]
    assert figure.bbox.y1 > title.y1 > title.y0 > below.y1


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make pictures whose captions and numbers are all that matters."""
    monkeypatch.setattr(figures_module, "themed_svg", lambda _: b"<svg/>")


def drawn(cases: Cases) -> dict[str, Picture]:
    with experiment_of(cases) as experiment:
        found = list(pictures(experiment))
    for picture in found:
        assert ElementTree.fromstring(picture.svg).tag.endswith("svg")
        assert picture.caption.endswith(".")
        text = picture.svg.decode()
        assert not any(word in text for word in ("<dc:date>", "<script", 'href="http'))
    return {picture.name: picture for picture in found}


def test_the_figures_of_two_cases_on_the_grid() -> None:
    found = drawn([(ON, outcomes("ddww")), (OFF, outcomes("ddoo"))])
    assert list(found) == ["success", "steps", "modes", "stuck-1"]
    assert "Wilson's 95% intervals" in found["success"].caption
    assert "of 8 episodes" in found["stuck-1"].caption
    assert "random in each episode" in found["stuck-1"].caption


def test_time_and_energy_are_drawn_only_where_they_are_measured() -> None:
    cases = [
        ({"backend": backend, "escape": escape}, [row(0, joules=77), row(1)])
        for backend in ("grid", "physics")
        for escape in (True, False)
    ]
    found = drawn(cases)
    assert {"seconds", "joules"} <= found.keys()
    assert found["seconds"].svg != found["joules"].svg
    assert "Time of a delivery, backend physics" in found["seconds"].caption
    assert "Energy of a delivery, backend physics" in found["joules"].caption
    assert not {"seconds", "joules"} & drawn(cases[:2]).keys()


@pytest.mark.parametrize(
    ("cases", "max_cells", "names"),
    [
        ([({}, outcomes("dw"))], 84, ["modes", "stuck-1"]),
        ([({}, outcomes("dw"))], 83, ["modes"]),
        ([({}, outcomes("dd"))], 84, ["modes"]),
        ([({"layout": "random"}, outcomes("ww"))], 84, ["modes"]),
    ],
    ids=["a single case", "too large to be seen", "no failure", "random layouts"],
)
@pytest.mark.usefixtures("undrawn")
def test_a_map_is_drawn_of_a_layout_with_failures(monkeypatch: pytest.MonkeyPatch,
    cases: list[Any], max_cells: int, names: list[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(figures_module, "MAX_CELLS", max_cells)
    assert list(drawn(cases)) == names


@pytest.mark.usefixtures("undrawn")
def test_the_layouts_with_the_most_episodes_have_maps(tmp_path: Path) -> None:
    cases = []
    for number in range(MAX_MAPS + 2):
        file = hall(tmp_path, number)
        cases.append(({"layout": file}, outcomes("w" * (number + 1))))
    found = drawn(cases)
    maps = [found[name].caption for name in found if name.startswith("stuck")]
    assert len(maps) == MAX_MAPS
    assert "hall5.txt: of 6 episodes" in maps[0]
    assert "Pickup (P) and dropoff (D) are those of the layout in every episode." in maps[0]
    assert "hall2.txt: of 3 episodes" in maps[-1]


@pytest.mark.usefixtures("undrawn")
def test_the_caption_names_pooled_settings() -> None:
    cases = [
        ({"battery": battery, "view_radius": radius}, outcomes("dw"))
        for battery in range(1, 10)
        for radius in range(8)
    ]
    found = drawn(cases)
    assert found["success"].caption == (
        "Delivered: share of all episodes, without intervals: several combinations are pooled, "
        "which share their seeds; pooled over view_radius."
    )
    assert found["modes"].caption.endswith("as shares; pooled over view_radius.")


@pytest.mark.usefixtures("undrawn")
def test_points_of_one_combination_each_have_intervals() -> None:
    cases = [({"battery": n, "view_radius": n}, outcomes("dw")) for n in range(1, 10)]
    assert drawn(cases)["success"].caption == (
        "Delivered: share of all episodes, with Wilson's 95% intervals; of different battery."
    )


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ((20, 20), "with bootstrap 95% intervals"),
        ((19, 19), "without intervals: fewer than 20 were delivered"),
        (
            (20, 5),
            "with bootstrap 95% intervals, but none where fewer than 20 were delivered; "
            "5 to 20 episodes a combination",
        ),
    ],
)
def test_the_caption_states_which_intervals_are_drawn(counts: tuple[int, int], words: str) -> None:
    lines = [[row(n, steps=30 + n) for n in range(count)] for count in counts]
    with experiment_of(list(zip((ON, OFF), lines, strict=True))) as experiment:
        chart = measure_figure(chart_of(experiment), "", STEPS)
        [steps] = [each.caption for each in pictures(experiment) if each.name == "steps"]
    assert chart is not None
    whiskers = [
        segment
        for container in chart.axes[0].containers
        for segment in container.lines[2][0].get_segments()  # type: ignore[attr-defined]
    ]
    assert sum(each.size > 0 for each in whiskers) == sum(count >= 20 for count in counts)
    assert steps == f"Steps of a delivery: mean of what was delivered, hard or easy, {words}."


@pytest.mark.usefixtures("undrawn")
def test_the_caption_says_that_nearly_equal_values_have_no_interval() -> None:
    rows = [row(n, steps=90 if n == 7 else 30) for n in range(40)]
    assert drawn([(ON, rows), (OFF, rows)])["steps"].caption.endswith(
        "hard or easy, without intervals: nearly all values are equal."
    )


@pytest.mark.usefixtures("undrawn")
def test_the_caption_states_how_many_values_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures_module, "MAX_POINTS", 5)
    found = drawn([({"battery": n}, outcomes("dw")) for n in range(1, 40)])
    assert "; 5 of 39 values of battery." in found["success"].caption


def test_the_same_results_make_the_same_bytes() -> None:
    cases = [(ON, outcomes("ddww")), (OFF, outcomes("ddoo"))]
    with experiment_of(cases) as experiment:
        assert list(pictures(experiment)) == list(pictures(experiment))


@pytest.mark.parametrize(("place", "sheet"), [*enumerate(SHEETS)])
def test_each_text_of_a_figure_is_at_least_12_pixels_high_on_a_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: int, sheet: PaperSize
) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(
        figures_module, "themed_svg", lambda each: (figures.append(each), b"<svg/>")[1]
    )
    hall = tmp_path / "hall.txt"
    hall.write_text(f"{'#' * 30}\n#P{'.' * 26}D#\n{'#' * 30}")
    cases = [
        ({"layout": layout, "escape": escape}, [row(seed, mode) for seed, mode in modes])
        for layout in ("default", str(hall))
        for escape in (True, False)
        for modes in [[*enumerate(("delivered", "wandering", "oscillation"))]]
    ]
    drawn(cases)
    figures = figures[place :: len(SHEETS)]
    assert len(figures) == 5
    assert all(figure.get_figwidth() <= sheet.width + 1e-9 for figure in figures)
    letters = [{text.get_text() for text in each.findobj(Text)} & {"P", "D"} for each in figures]
    assert letters == [set(), set(), set(), set(), {"P", "D"}], "only of the layout that keeps them"
    sizes = {
        text.get_text(): text.get_fontsize()
        for figure in figures
        for text in figure.findobj(Text)
        if text.get_text() and text.get_visible()
    }
    assert {"P", "wandering", "escape on", "33%", "layout", "steps"} <= sizes.keys()
    # SVG has 96 pixels an inch and 72 points.
    assert min(sizes.values()) * 96 / 72 >= 12, sizes


def luminance(color: str) -> float:
    """Return the relative luminance of WCAG 2.2."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in to_rgb(color)
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: ColorType, other: ColorType, *, dark: bool) -> float:
    """Return the contrast of two colours of a figure on a light page or on a dark one."""
    shown = [
        DARK.get(to_hex(each), to_hex(each)) if dark else to_hex(each) for each in (one, other)
    ]
    low, high = sorted(map(luminance, shown))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_what_is_drawn_can_be_seen_on_both_pages(dark: bool) -> None:
    assert contrast(INK, PAPER, dark=dark) > 12
    assert contrast(COLORS["#"], COLORS["."], dark=dark) > 2.5
    for color in (*LINES, *MODE_COLORS.values()):
        assert contrast(color, PAPER, dark=dark) > (2.5 if dark else 1.5), color
    for color in MODE_COLORS.values():
        assert contrast(ink_on(color), color, dark=dark) > 4.5, color
    for level in range(HEAT.N):
        share = level / (HEAT.N - 1)
        assert contrast(ink_of_heat(share), HEAT(share), dark=dark) > 3, level


def test_colours_of_a_chart_differ_on_a_dark_page() -> None:
    for colors in (LINES, [to_hex(HEAT(level)) for level in range(HEAT.N)]):
        assert len({DARK.get(color, color) for color in colors}) == len(colors)


def test_the_style_replaces_the_colours_that_are_used_and_nothing_else_changes() -> None:
    figure = Figure(figsize=(1, 1), facecolor=PAPER)
    figure.text(0.1, 0.1, "a", color=INK)
    figure.text(0.1, 0.5, "b", color="#d55e00")
    file = BytesIO()
    save_svg(figure, file)
    svg = themed_svg(figure).decode()
    assert STYLE.sub("", svg) == file.getvalue().decode()
    [rules] = STYLE.findall(svg)
    ink, paper = to_hex(INK), to_hex(PAPER)
    assert rules == (
        f'[style*="fill: {ink}"]{{fill:{DARK[ink]}!important}}'
        f'[style*="fill: {paper}"]{{fill:{DARK[paper]}!important}}'
    )


# Heat maps.

ROWS = ("######", "#....#", "#..#.#", "#....#", "######")
LARGE = random_layout(20, 40, 0.2, 3).rows
TALL = ("#" * 4, *["#.P#", "#D.#"] * 20, "#" * 4)


def counts(*places: tuple[int, int, int], rows: tuple[str, ...] = ROWS) -> NDArray[np.int64]:
    grid = np.zeros((len(rows), len(rows[0])), dtype=np.int64)
    for at_row, col, count in places:
        grid[at_row, col] = count
    return grid


def titled(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_title(loc="left")]


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


def test_heat_maps_are_in_the_order_of_the_modes(store: Store) -> None:
    case_id = store.case_id(make_case({}))
    store.add(case_id, [row(99)])
    assert stuck_cells(store, DEFAULT_LAYOUT.rows, [case_id]) == {}, "without failures"
    store.add(case_id, [row(n, mode) for n, mode in enumerate(reversed(MODES))])
    assert tuple(stuck_cells(store, DEFAULT_LAYOUT.rows, [case_id])) == MODES[1:]


def test_a_panel_of_a_heat_map_has_its_mode_its_count_and_its_share() -> None:
    stuck = {"wandering": counts((1, 2, 900), (3, 3, 100)), "stalled": counts((1, 1, 1))}
    figure = stuck_heat_map(ROWS, stuck, 4000)
    titles = [axes.get_title(loc="left") for axes in titled(figure)]
    assert titles == ["wandering: 1,000 (25.0%)", "stalled: 1 (0.0%)"]


@pytest.mark.parametrize(
    ("rows", "count"), [(ROWS, 1), (LARGE, 4), (TALL, 5), (ROWS, len(MODES) - 1)]
)
@pytest.mark.parametrize("sheet", SHEETS)
def test_heat_maps_neither_overlap_nor_leave_the_figure(
    rows: tuple[str, ...], count: int, sheet: PaperSize
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
