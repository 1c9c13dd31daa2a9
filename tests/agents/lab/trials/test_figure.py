"""The figures that compare agents: points, intervals and agents without deliveries."""

from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.trials.figure import scores_figure
from agents.lab.trials.scores import GRID_MEASURES


def test_each_measure_has_a_panel_and_each_task_a_colour_without_missing_values() -> None:
    one = {"one": scores_of([BAD] * 3), "two": scores_of([GOOD] * 30)}
    figure = scores_figure({"small, 3 each": one, "large, 3 each": one})
    figure.pixels()
    assert figure._suptitle.get_text() == "3 each"  # type: ignore[attr-defined]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["small", "large"]
    found = [
        [[float(each) for each in mark[0].get_ydata()] for mark in axes.containers]
        for axes in figure.axes
    ]
    all_of, one_of = [[-0.1, 0.9], [0.1, 1.1]], [[0.9], [1.1]]
    assert found == [all_of, one_of, one_of, all_of, one_of, one_of]
    share = figure.axes[0].containers[0]
    assert list(share[0].get_xdata()) == [0, 1]
    assert share[2][0].get_segments()[1][1][0] == 1
    assert 0.8 < share[2][0].get_segments()[1][0][0] < 0.9
    grid = scores_figure({"": one}, GRID_MEASURES)
    assert (len(figure.axes), len(grid.axes)) == (6, 4), "no panel is empty"
    assert [text.get_text() for text in grid.axes[0].get_yticklabels()] == ["one", "two"]
