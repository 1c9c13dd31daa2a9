"""The figures that compare agents: points, intervals and agents without deliveries."""

from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.trials.figure import scores_figure


def test_each_measure_has_a_point_with_its_interval_or_the_words_no_delivery() -> None:
    figure = scores_figure({"": {"one": scores_of([BAD] * 3), "two": scores_of([GOOD] * 30)}})
    figure.pixels()
    assert [len(axes.containers) for axes in figure.axes] == [2, 1, 1, 2, 1, 1]
    words = [[text.get_text() for text in axes.texts] for axes in figure.axes]
    assert words == [[], ["no delivery"], ["no delivery"], [], ["no delivery"], ["no delivery"]]
    [first, second] = figure.axes[0].containers
    assert (first[0].get_xdata()[0], first[0].get_ydata()[0]) == (0, 0)
    assert (second[0].get_xdata()[0], second[0].get_ydata()[0]) == (1, 1)
    [ends] = second[2][0].get_segments()
    assert 0.8 < ends[0][0] < ends[1][0] == 1
