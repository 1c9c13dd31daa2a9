"""The charts of a report: points, intervals, lines, bars and labels."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.results_files import experiment_of, outcomes
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from agents.lab.experiments.plan import make_plan
from agents.lab.reports.analysis.design import make_design
from agents.lab.reports.analysis.results import STEPS, SUCCESS, Experiment
from agents.lab.reports.figures import roles as roles_module
from agents.lab.reports.figures.measure import measure_chart
from agents.lab.reports.figures.modes import MODE_COLORS, modes_chart
from agents.lab.reports.figures.panels import (
    LETTERS,
    MAX_TICKS,
    PHONE,
    WIDE,
    Sheet,
    draw_legend,
    fitting,
    make_panels,
    places_of,
    prepare_axis,
)
from agents.lab.reports.figures.roles import roles_of
from warehouse_core.records.failure_modes import FLEET_MODES, MODES
from warehouse_core.viz.figure import SceneFigure


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


def draw(experiment: Experiment, *, modes: bool = False) -> SceneFigure:
    if modes:
        return modes_chart(experiment, "Modes")
    figure = measure_chart(experiment, experiment.design, "Success", SUCCESS)
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


def test_the_legend_names_each_line_in_order(experiment: Experiment) -> None:
    [legend] = draw(experiment).legends
    assert [text.get_text() for text in legend.get_texts()] == ["escape on", "escape off"]


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
        assert measure_chart(experiment, experiment.design, "", STEPS) is None

    with experiment_of([({}, outcomes("dw"))]) as experiment:
        assert measure_chart(experiment, experiment.design, "", SUCCESS) is None
        [axes] = modes_chart(experiment, "").axes
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
    monkeypatch.setattr(roles_module, "MAX_POINTS", 20)
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


def test_many_values_have_few_ticks() -> None:
    cases = [({"battery": battery}, outcomes("dw")) for battery in range(1, 60)]
    with experiment_of(cases) as experiment:
        assert len(draw(experiment).axes[0].get_xticks()) <= MAX_TICKS
        assert len(draw(experiment, modes=True).axes[0].get_xticks()) <= MAX_TICKS


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


def test_only_ordered_values_are_joined_by_a_line() -> None:
    for settings in ({"battery": [1, 2]}, {"escape": [True, False]}):
        [(name, values)] = settings.items()
        cases = [({name: value}, outcomes("dw")) for value in values]
        with experiment_of(cases) as experiment:
            [axes] = draw(experiment).axes
        line = axes.containers[0].lines[0]
        assert line.get_linestyle() == ("-" if name == "battery" else "None")


def test_the_axes_of_a_chart_say_what_they_are(experiment: Experiment) -> None:
    [axes] = draw(experiment).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("battery", "")
    assert axes.get_title(loc="left") == ""
    low, high = axes.get_ylim()
    assert -0.05 < low < 0
    assert 1 < high < 1.05
    assert axes.yaxis.get_major_formatter()(0.5) == "50%"
    low, high = axes.get_xlim()
    assert -20 < low < 0
    assert 180 < high < 200
    assert list(axes.get_xticks()) == [0, 40, 180]
    steps = measure_chart(experiment, experiment.design, "Steps", STEPS)
    assert steps is not None
    [axes] = steps.axes
    assert (axes.get_ylabel(), axes.get_ylim()[0]) == ("steps", 0)
    assert steps.get_suptitle() == "Steps"


def test_the_axes_of_outcomes_say_what_they_are(experiment: Experiment) -> None:
    for axes in draw(experiment, modes=True).axes:
        assert axes.get_xlabel() == "battery"
        assert axes.get_ylim() == (0, 1)
        low, high = axes.get_xlim()
        assert -1 < low < -0.4
        assert high > len(axes.get_xticks()) - 0.6
    assert axes.yaxis.get_major_formatter()(0.5) == "50%"
    assert list(axes.get_xticks()) == [0, 1]
    with experiment_of([({}, outcomes("dw"))]) as one:
        [axes] = modes_chart(one, "").axes
    assert axes.get_xlabel() == ""


def test_a_share_is_written_into_the_middle_of_its_part_where_there_is_room() -> None:
    words = "d" * 11 + "o" + "w" * 2
    with experiment_of([({}, outcomes(words))]) as experiment:
        [axes] = modes_chart(experiment, "").axes
    written = {text.get_text(): text.get_position() for text in axes.texts}
    assert written == {"79%": (0, pytest.approx(11 / 28)), "14%": (0, pytest.approx(13 / 14))}
    assert all((text.get_ha(), text.get_va()) == ("center",) * 2 for text in axes.texts)
    batteries = [({"battery": battery}, outcomes("d")) for battery in range(1, 13)]
    with experiment_of(batteries) as experiment:
        [wide], [phone] = (modes_chart(experiment, "", sheet).axes for sheet in (WIDE, PHONE))
    assert (len(wide.texts), len(phone.texts)) == (12, 0)


def test_a_line_without_values_along_the_axis_has_a_band_of_its_interval() -> None:
    cases = [({"memory": memory}, outcomes("dw" * 20)) for memory in (2, 9)]
    cases.append(({"escape": False}, outcomes("dooo" * 20)))
    with experiment_of(cases) as experiment:
        [axes] = draw(experiment).axes
        interval = experiment.results(3).interval(SUCCESS)
    assert interval is not None
    [band] = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    assert (band.get_y(), band.get_y() + band.get_height()) == pytest.approx(interval[1:])
    assert 0 < (band.get_alpha() or 1) < 0.5
    [line] = [each for each in axes.lines if each.get_linestyle() == "--"]
    assert to_rgb(band.get_facecolor()) == to_rgb(line.get_color())


def test_lines_differ_in_colour_and_marker_and_stand_side_by_side() -> None:
    cases = [
        ({"battery": battery, "view_radius": radius}, outcomes("dw" * 20))
        for battery in (100, 200, 300, 400)
        for radius in (1, 2, 3)
    ]
    with experiment_of(cases) as experiment:
        [axes] = draw(experiment).axes
    lines = [each.lines[0] for each in axes.containers]
    assert len({line.get_color() for line in lines}) == 3
    assert len({line.get_marker() for line in lines}) == 3
    first, middle, last = (np.asarray(line.get_xdata()) for line in lines)
    assert middle.tolist() == [0, 100, 200, 300]
    assert (last - middle).tolist() == pytest.approx((middle - first).tolist())
    assert 0 < last[0] < 10
    for line, container in zip(lines, axes.containers, strict=True):
        [segments] = [each.get_segments() for each in container.lines[2]]
        assert [segment[0, 0] for segment in segments] == list(line.get_xdata())


@pytest.mark.parametrize(
    ("sheet", "count", "columns", "lines"),
    [(WIDE, 1, 1, 1), (WIDE, 3, 3, 1), (WIDE, 4, 3, 2), (PHONE, 2, 1, 2)],
)
def test_panels_are_in_lines_below_a_title_and_a_legend(
    sheet: Sheet, count: int, columns: int, lines: int
) -> None:
    keys = [f"a key {number}" for number in range(8)]
    panels = make_panels(sheet, "A title", count, keys)
    figure, height = panels.figure, panels.figure.get_figheight()
    assert len(panels.axes) == len(figure.axes) == count
    boxes = [each.get_position() for each in panels.axes]
    assert len({round(box.x0, 6) for box in boxes}) == columns
    assert len({round(box.y0, 6) for box in boxes}) == lines
    assert min(box.height for box in boxes) * height > 2
    assert boxes[0].width * sheet.width == pytest.approx(panels.letters / LETTERS, abs=0.3)
    more = make_panels(sheet, "A title", count, [*keys, *keys]).figure.get_figheight() - height
    two = make_panels(sheet, "a word " * 20, count, keys[:1])
    one = make_panels(sheet, "A title", count, keys[:1]).figure.get_figheight()
    per_row = panels.legend[0]
    rows = math.ceil(16 / per_row) - math.ceil(8 / per_row)
    assert 0.2 * rows < more < 0.3 * rows, "as many rows of the legend again"
    titles = two.figure.get_suptitle().count("\n")
    assert titles >= 1
    assert 0.2 * titles < two.figure.get_figheight() - one < 0.3 * titles
    draw_legend(panels, [(key, Line2D([], [])) for key in keys])
    figure.pixels()
    [legend] = figure.legends
    below = legend.get_window_extent()
    assert below.x1 < figure.bbox.x1
    assert below.y0 > max(each.get_window_extent().y1 for each in panels.axes)
    title = figure._suptitle.get_window_extent()  # type: ignore[attr-defined]
    assert figure.bbox.y1 > title.y1 > title.y0 > below.y1
    assert 0 < title.x0 < 0.3 * figure.dpi


def test_names_that_are_too_long_lose_their_middles_and_then_some_are_left_out() -> None:
    assert fitting(["a" * 80], 81) == (1, ["a" * 80])
    assert fitting(["a" * 40 + "b" * 41], 81) == (1, ["a" * 40 + "…" + "b" * 39])
    assert fitting(["a" * 20 + "b" * 20, "c"], 42) == (1, ["a" * 10 + "…" + "b" * 9, "c"])
    assert fitting(["abcdefgh"] * 12, 108) == (1, ["abcdefgh"] * 12)
    assert fitting(["abcdefgh"] * 12, 107) == (1, ["abc…fgh"] * 12)
    assert fitting(["abcdefgh"] * 12, 40) == (2, ["ab…gh"] * 6)
    assert fitting([*map(str, range(40))], 81) == (4, [*map(str, range(0, 40, 4))])
    assert fitting(["abcdefgh"] * 3, 2) == (3, ["ab…gh"])


def test_places_are_numbers_from_the_first_or_else_one_after_the_other() -> None:
    design = make_design(dict(enumerate(make_plan({"battery": [20, 60, 200]}, 1, 0).cases)))
    assert places_of(roles_of(design).axis) == {20: 0, 60: 40, 200: 180}  # type: ignore[arg-type]
    design = make_design(dict(enumerate(make_plan({"escape": [True, False]}, 1, 0).cases)))
    axis = roles_of(design).axis
    assert axis is not None
    places = places_of(axis)
    assert [*places.values()] == [0, 1]
    [axes] = make_panels(WIDE, "", 1, []).axes
    prepare_axis(axes, axis, places, 80)
    assert axes.get_xlim() == (-0.5, 1.5)


@pytest.mark.parametrize("letters", [20, 26, 80])
@pytest.mark.parametrize("names", [range(20, 260, 20), range(10**6, 10**6 + 9), range(1, 500)])
def test_names_along_an_axis_have_room_beside_each_other(names: range, letters: int) -> None:
    step, shown = fitting(list(map(str, names)), letters)
    assert 1 <= len(shown) == len(names[::step])
    assert sum(len(name) + 1 for name in shown) <= letters
