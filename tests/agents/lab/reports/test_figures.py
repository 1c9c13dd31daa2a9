"""The figures of a report: points, intervals, lines, bars, labels and captions."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.results_files import Cases, experiment_of, hall, outcomes

from agents.lab.experiments.plan import make_plan
from agents.lab.experiments.store import Store
from agents.lab.reports import figures as figures_module
from agents.lab.reports.figures import (
    MAX_MAPS,
    Picture,
    ReportChart,
    measure_figure,
    modes_figure,
    pictures,
    roles_of,
)
from agents.lab.reports.results import STEPS, SUCCESS, Design, Experiment
from warehouse_core.viz.figure import SceneFigure


def roles(**choices: Any) -> list[Any]:
    found = roles_of(Design(dict(enumerate(make_plan(choices, 1, 0).cases))))
    return [factor.name if factor else None for factor in (*found[:3], *found[3])]


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


def chart_of(experiment: Experiment) -> ReportChart:
    return ReportChart(experiment, experiment.design)


def draw(experiment: Experiment, *, modes: bool = False) -> SceneFigure:
    chart = chart_of(experiment)
    figure = modes_figure(chart, "Modes") if modes else measure_figure(chart, "Success", SUCCESS)
    assert figure is not None
    return figure


def test_the_ordered_factor_with_the_most_values_is_on_the_axis() -> None:
    assert roles(battery=[20, 40, 60], escape=[True, False]) == ["battery", "escape", None]
    assert roles(memory=[2, 5], battery=[1, 2, 3], escape=[True, False]) == [
        "battery", "escape", "memory",
    ]  # fmt: skip
    assert roles(layout="random", size=["7x12", "9x9"], battery=[1, 2, 3])[0] == "battery"
    assert roles(escape=[True, False])[:2] == ["escape", None]
    assert roles() == [None, None, None]


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


def test_of_many_values_along_the_axis_some_are_drawn() -> None:
    cases = [({"battery": battery}, outcomes("d")) for battery in range(20, 140)]
    with experiment_of(cases) as experiment:
        chart = chart_of(experiment)
    assert [*chart.lines[None, None]] == list(range(20, 140, 3))
    assert chart.left_out == "; only one in 3 values of battery is drawn"


def test_without_deliveries_or_differences_there_is_no_chart_of_a_measure() -> None:
    cases = [({"battery": battery}, outcomes("ww")) for battery in (1, 2)]
    with experiment_of(cases) as experiment:
        assert measure_figure(chart_of(experiment), "", STEPS) is None
    with experiment_of([({}, outcomes("d" * 11 + "o" + "w" * 2))]) as experiment:
        assert measure_figure(chart_of(experiment), "", SUCCESS) is None
        [axes] = modes_figure(chart_of(experiment), "").axes
    assert [label.get_text() for label in axes.get_xticklabels()] == ["all episodes"]
    written = {text.get_text(): text.get_position() for text in axes.texts}
    assert written == {"79%": (0, pytest.approx(11 / 28)), "14%": (0, pytest.approx(13 / 14))}


@pytest.mark.parametrize("name", ["$x_{", "a very long name of a hall" * 3])
def test_names_neither_overlap_nor_leave_the_figure_and_are_not_formulas(
    tmp_path: Path, name: str
) -> None:
    files = [tmp_path / f"{name} {number}.txt" for number in range(5)]
    for file in files:
        file.write_text("#####\n#P.D#\n#####")
    words = outcomes("dwo")
    cases = [({"layout": str(file), "escape": on}, words) for file in files for on in (True, False)]
    with experiment_of(cases) as experiment:
        for figure in (draw(experiment), draw(experiment, modes=True)):
            figure.pixels()
            texts = figure.axes[-1].get_xticklabels()
            labels = [label.get_window_extent() for label in texts]
            assert len({label.get_text() for label in texts}) == 5
            assert all(one.x1 < other.x0 for one, other in pairwise(labels))
            drawn = figure.get_tightbbox(figure.canvas.get_renderer())
            width, height = figure.get_size_inches()
            assert 0 <= drawn.x0 < drawn.x1 <= width
            assert 0 <= drawn.y0 < drawn.y1 <= height
            [legend] = figure.legends
            below = legend.get_window_extent()
            title = figure._suptitle.get_window_extent()  # type: ignore[attr-defined]
            assert title.y0 > below.y1 > below.y0 > figure.axes[0].get_window_extent().y1


def drawn(cases: Cases) -> dict[str, Picture]:
    with experiment_of(cases) as experiment:
        found = list(pictures(experiment))
    for picture in found:
        assert ElementTree.fromstring(picture.svg).tag.endswith("svg")
        assert picture.caption.endswith(".")
        text = picture.svg.decode()
        assert not any(word in text for word in ("<dc:date>", "<script", 'href="http'))
    return {picture.name: picture for picture in found}


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
def test_a_map_is_drawn_of_a_layout_with_failures(monkeypatch: pytest.MonkeyPatch,
    cases: list[Any], max_cells: int, names: list[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(figures_module, "MAX_CELLS", max_cells)
    assert list(drawn(cases)) == names


def test_the_layouts_with_the_most_episodes_have_maps(tmp_path: Path) -> None:
    cases = []
    for number in range(MAX_MAPS + 2):
        file = hall(tmp_path, number)
        cases.append(({"layout": file}, outcomes("w" * (number + 1))))
    found = drawn(cases)
    maps = [found[name].caption for name in found if name.startswith("stuck")]
    assert len(maps) == MAX_MAPS
    assert "hall5.txt: number of episodes with each failure mode, out of 6 episodes," in maps[0]
    assert "Pickup (P) and dropoff (D) are the stations of the layout in every episode." in maps[0]
    assert "hall2.txt: number of episodes with each failure mode, out of 3 episodes," in maps[-1]


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "r.sqlite") as opened:
        yield opened
