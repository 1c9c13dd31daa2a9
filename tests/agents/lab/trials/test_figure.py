"""The figures that compare agents: marks, intervals, failures, and the message above them."""

import pytest
from helpers.results_files import BAD, GOOD, scores_of
from matplotlib.text import Text

from agents.lab.trials.figure import PANELS, message, scores_figure, sizes_figure
from agents.lab.trials.rows import Row
from agents.lab.trials.scores import MEASURES

SLOW = GOOD._replace(steps=30)
GROUPS = {
    "small": {"one": scores_of([GOOD] * 30), "a" * 60: scores_of([GOOD] * 20 + [BAD] * 10)},
    "large": {"one": scores_of([BAD] * 30), "a" * 60: scores_of([GOOD] * 30)},
}


def test_each_task_has_its_message_its_title_and_its_panels() -> None:
    figure = sizes_figure(GROUPS, "What is measured.")
    figure.pixels()
    assert [axes.get_title(loc="left") for axes in figure.axes] == 2 * [p.title for p in PANELS]
    texts = [text.get_text() for text in figure.texts]
    assert texts[0].startswith("All 30 delivered by one, at 20 steps a delivery;")
    assert texts[1::2] == ["small", "large"]
    assert texts[4] == "What is measured."
    failures = [[text.get_text() for text in axes.texts] for axes in figure.axes[::3]]
    assert failures == [["failed", "0", "10"], ["failed", "30", "0"]]


def test_nothing_overlaps_or_leaves_the_figure() -> None:
    figure = sizes_figure(GROUPS, "What is measured.")
    figure.pixels()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    panels = [axes.get_tightbbox(renderer) for axes in figure.axes]
    boxes = [*panels, *(text.get_window_extent() for text in figure.texts)]
    for number, box in enumerate(boxes):
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.x1
        assert box.y0 >= 0
        assert box.y1 <= figure.bbox.y1
        assert not [other for other in boxes[:number] if box.overlaps(other)], number


def test_the_figure_has_a_mark_for_each_agent_in_each_panel() -> None:
    scores = {"one": scores_of([GOOD] * 30), "a" * 60: scores_of([GOOD] * 3)}
    figure = scores_figure(scores, "A title", "What is measured.")
    assert [axes.get_title(loc="left") for axes in figure.axes] == [each.title for each in MEASURES]
    assert "What is measured." in [text.get_text() for text in figure.texts]
    values = [
        [bar.get_width() for bar in axes.patches]
        + [line.get_xdata()[0] for line in axes.lines if line.get_marker() == "o"]  # type: ignore[index]
        for axes in figure.axes
    ]
    assert values == [[1, 1], [20, 20], [2, 2], [5, 5], [40, 40], [900, 900]]
    intervals = [sum(line.get_marker() == "|" for line in axes.lines) for axes in figure.axes]
    assert intervals == [2, 1, 1, 1, 1, 1]
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())  # type: ignore[attr-defined]
    width, height = figure.get_size_inches()
    assert drawn.x0 >= 0
    assert drawn.x1 <= width
    assert drawn.y1 <= height


def test_an_agent_without_deliveries_has_a_text_instead_of_a_mark() -> None:
    figure = scores_figure({"one": scores_of([BAD] * 3)}, "")
    figure.pixels()
    assert [len(axes.patches) for axes in figure.axes] == [2, 0, 0, 1, 0, 0]
    words = [[text.get_text() for text in axes.texts] for axes in figure.axes[1:]]
    assert words == [["no delivery"], ["no delivery"], [], ["no delivery"], ["no delivery"]]


def test_failures_are_counted_and_fill_the_bars_of_deliveries() -> None:
    figure = scores_figure(
        {"one": scores_of([GOOD] * 30 + [BAD] * 10), "two": scores_of([GOOD])}, ""
    )
    first = figure.axes[0]
    assert [text.get_text() for text in first.texts] == ["failed", "10", "0"]
    bars = sorted((bar.get_x(), bar.get_width()) for bar in first.patches)  # type: ignore[attr-defined]
    assert bars == [(0, 0.75), (0, 1), (0.75, 0.25)]


@pytest.mark.parametrize(
    ("scores", "said"),
    [
        ({"a": [BAD] * 2}, "No agent delivered in 2 episodes"),
        ({"a": [GOOD]}, "All 1 delivered by a, at 20 steps a delivery"),
        (
            {"a": [BAD] * 3, "b": [SLOW, SLOW, SLOW], "c": [GOOD, GOOD, BAD], "d": [GOOD] * 3},
            "All 3 delivered by b and d, at 20 to 30 steps a delivery;\n"
            "c failed 1 time, at 120 steps",
        ),
        (
            {"a": [BAD] * 2, "b": [GOOD, BAD]},
            "Most delivered by b: 1 of 2, at 220 steps a delivery;\na failed 2 times",
        ),
        (
            dict.fromkeys("abcde", [GOOD] * 2),
            "All 2 delivered by 5 agents, at 20 steps a delivery",
        ),
    ],
)
def test_the_message_is_computed_from_the_scores(scores: dict[str, list[Row]], said: str) -> None:
    assert message({name: scores_of(runs) for name, runs in scores.items()}) == said


def test_the_message_is_the_largest_text_however_long_it_is() -> None:
    scores = {f"{name}{'n' * 60}": scores_of([GOOD]) for name in "abcd"}
    figure = scores_figure(scores, "200 episodes", "What is measured.")
    figure.pixels()
    [said] = [text for text in figure.texts if text.get_text().startswith("All 1 delivered")]
    assert said.get_fontsize() > max(
        text.get_fontsize() for text in figure.findobj(Text) if text is not said
    )
    box = said.get_window_extent()
    [below] = [text for text in figure.texts if text.get_text() == "200 episodes"]
    assert said.get_text().count("\n") >= 1
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    assert below.get_window_extent().y1 <= box.y0
    assert below.get_window_extent().y0 > figure.axes[0].title.get_window_extent().y1
