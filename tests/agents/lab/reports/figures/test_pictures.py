"""The figures of a report: which are drawn, and their captions."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest
from helpers.results_files import OFF, ON, Cases, experiment_of, hall, outcomes, row
from matplotlib.figure import Figure
from matplotlib.text import Text

from agents.lab.reports.analysis.results import STEPS
from agents.lab.reports.figures import pictures as picture_module
from agents.lab.reports.figures import roles
from agents.lab.reports.figures.measure import measure_chart
from agents.lab.reports.figures.panels import SHEETS, Sheet
from agents.lab.reports.figures.pictures import MAX_MAPS, Picture, pictures


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make pictures whose captions and numbers are all that matters."""
    monkeypatch.setattr(picture_module, "themed_svg", lambda _: b"<svg/>")


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
    monkeypatch.setattr(picture_module, "MAX_CELLS", max_cells)
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
        chart = measure_chart(experiment, experiment.design, "", STEPS)
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
    monkeypatch.setattr(roles, "MAX_POINTS", 5)
    found = drawn([({"battery": n}, outcomes("dw")) for n in range(1, 40)])
    assert "; 5 of 39 values of battery." in found["success"].caption


def test_the_same_results_make_the_same_bytes() -> None:
    cases = [(ON, outcomes("ddww")), (OFF, outcomes("ddoo"))]
    with experiment_of(cases) as experiment:
        assert list(pictures(experiment)) == list(pictures(experiment))


@pytest.mark.parametrize(("place", "sheet"), [*enumerate(SHEETS)])
def test_each_text_of_a_figure_is_at_least_12_pixels_high_on_a_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: int, sheet: Sheet
) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(
        picture_module, "themed_svg", lambda each: (figures.append(each), b"<svg/>")[1]
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
