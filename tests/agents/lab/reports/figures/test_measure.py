"""The charts of a report: points, intervals, lines, bars and labels."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.results_files import experiment_of, outcomes
from matplotlib.axes import Axes

from agents.lab.experiments.plan import make_plan
from agents.lab.reports.analysis.design import make_design
from agents.lab.reports.analysis.results import STEPS, SUCCESS, Experiment
from agents.lab.reports.figures import roles as roles_module
from agents.lab.reports.figures.measure import measure_chart
from agents.lab.reports.figures.modes import MODE_COLORS, modes_chart
from agents.lab.reports.figures.panels import MAX_TICKS
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
