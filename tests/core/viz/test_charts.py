"""The axes of charts, and what is drawn into them."""

import math

from warehouse_core.viz.charts import BatteryBar, Chart, charts_of
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.tracks.series import Series
from warehouse_core.viz.tracks.track import Frame, Track


def test_steps_of_deliveries_are_written_as_early_or_late() -> None:
    figure = make_figure((3, 2))
    axes = figure.add_axes((0, 0, 1, 1))
    late = Series("Deliveries (steps)", "late", "dots", "warning", [1.0], [7.0], "late")
    Chart(figure, axes, [late], 1)
    words = [axes.yaxis.get_major_formatter()(steps) for steps in (-1234, 0, 7)]
    assert words == ["1,234 early", "on time", "7 late"]


def test_a_battery_has_a_bar_of_its_level_and_words_that_warn() -> None:
    levels = [40.0, 8.0, 7.9, 0.0, math.nan, 45.0]
    frames = [Frame(("..",), (), float(step)) for step in range(len(levels))]
    track = Track(frames, {"battery": levels}, full_battery=40.0)
    figure = make_figure((3, 2))
    axes = figure.add_axes((0, 0, 1, 1))
    bar, found = BatteryBar(figure, axes), []
    for frame in range(len(levels)):
        bar.show(track, frame)
        [words] = axes.texts
        whole, filled = (shape.path.get_extents() for shape in bar._bar.shapes)
        assert whole.width == 1
        assert (words.get_fontweight() == "bold") == (frame in (2, 3))
        found.append((filled.width, words.get_text()))
    assert found == [
        (1, "battery 40 of 40"),
        (0.2, "battery 8 of 40"),
        (0.1975, "battery 7.9 of 40  LOW!"),
        (0, "battery 0 of 40  EMPTY!"),
        (0, "battery unknown"),
        (1, "battery 45 of 40"),
    ]


def test_charts_are_those_that_have_something_to_show() -> None:
    still = Track([Frame(("..",), (), 0.0)], {"rewards": [0.0]})
    assert [*charts_of(still, [0.0])] == ["Reward"]
    assert [*charts_of(Track(still.frames, {}), [0.0])] == []
