"""The axes of charts, and what is drawn into them."""

import math
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from agents.run_episode import run_episode
from warehouse_core.render.palette import BATTERY, COLORS, PAPER, WARNING
from warehouse_core.viz.charts import BatteryBar, Chart, charts_of, fit
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Track

METRICS: dict[str, list[float]] = {
    "released": [1, 3, 4, 4],
    "delivered": [0, 0, 2, 3],
    "battery_mean": [1.0, 0.9, 0.8, 0.7],
    "battery_lowest": [1.0, 0.8, 0.5, 0.25],
    "joules": [0, 1000, 2500, 5000],
}


@pytest.fixture
def physics() -> Track:
    return track_of_record(run_episode(backend="physics", seed=12))


def fleet() -> Track:
    """Return three steps of a fleet, whose two first deliveries are in time."""
    frames = [Frame(("..",), (), float(step), fleet=FleetFrame((), (), ())) for step in range(4)]
    return Track(frames, METRICS, lateness=[(2, -4), (2, 0), (3, 7)])


def chart_of(track: Track, title: str) -> tuple[Chart, Axes, list[Any]]:
    """Return a chart of a track in steps, its axes and its lines."""
    series = charts_of(track, [frame.progress for frame in track.frames])[title]
    figure = make_figure((3, 2))
    axes = figure.add_axes((0, 0, 1, 1))
    chart = Chart(figure, axes, series, track.steps, label="step")
    return chart, axes, axes.lines[1 : 1 + len(series)]


def points(line: Any) -> list[tuple[float, float]]:
    return [*zip(line.get_xdata(), line.get_ydata(), strict=True)]


def test_rewards_are_bars_and_their_sum_is_a_line() -> None:
    track = Track([Frame(("..",), (), float(n)) for n in range(3)], {"rewards": [0, 2, math.nan]})
    _, axes, (bars, total) = chart_of(track, "Reward")
    assert axes.get_title(loc="left") == "Reward: each step (bars), so far"
    tops = [point for point in points(bars) if point[1]]
    np.testing.assert_equal(tops, [(0, math.nan), (1, 2), (1, math.nan), (2, math.nan)])
    assert points(total) == [(0, 0), (1, 2), (2, 2)], "a missing reward counts as 0"


def test_both_distances_share_a_chart_in_the_colours_of_their_stations() -> None:
    _, axes, lines = chart_of(track_of_record(run_episode(seed=12)), "Distance (cells)")
    assert axes.get_title(loc="left") == "Distance (cells): to pickup, to dropoff (dashed)"
    assert [to_rgb(line.get_color()) for line in lines] == [COLORS["P"], COLORS["D"]]
    assert lines[0].get_linestyle() != lines[1].get_linestyle()


def test_orders_and_batteries_of_a_fleet_are_counted() -> None:
    _, _, (released, delivered) = chart_of(fleet(), "Orders")
    assert [y for _, y in points(released)] == METRICS["released"]
    assert [y for _, y in points(delivered)] == METRICS["delivered"]
    assert released.get_linewidth() < delivered.get_linewidth()
    assert {line.get_drawstyle() for line in (released, delivered)} == {"steps-post"}
    _, _, (mean, lowest) = chart_of(fleet(), "Battery (%)")
    assert [y for _, y in points(mean)] == pytest.approx([100, 90, 80, 70])
    assert [y for _, y in points(lowest)] == [100, 80, 50, 25]
    _, _, [energy] = chart_of(fleet(), "Energy used (kJ)")
    assert points(energy) == [(0, 0), (1, 1), (2, 2.5), (3, 5)]


def test_deliveries_in_time_are_dots_and_late_ones_triangles() -> None:
    _, axes, (in_time, late) = chart_of(fleet(), "Deliveries (steps)")
    assert (points(in_time), points(late)) == ([(2, -4), (2, 0)], [(3, 7)])
    assert (in_time.get_marker(), late.get_marker()) == ("o", "^")
    assert [to_rgb(line.get_color()) for line in (in_time, late)] == [BATTERY, WARNING]
    low, high = axes.get_ylim()
    assert -6 < low < -4
    assert 7 < high < 9
    words = [axes.yaxis.get_major_formatter()(steps) for steps in (-1234, 0, 7)]
    assert words == ["1,234 early", "on time", "7 late"]


def test_what_is_to_come_is_pale() -> None:
    chart, axes, _ = chart_of(fleet(), "Orders")
    chart.show(2.0)
    [veil] = axes.patches
    assert isinstance(veil.get_facecolor(), tuple)
    assert veil.get_facecolor()[:3] == PAPER
    left, _, right, _ = veil.get_bbox().extents  # type: ignore[attr-defined]
    assert left == 2 < axes.get_xlim()[1] < right
    [cursor] = axes.lines[3:]
    assert [x for x, _ in points(cursor)] == [2, 2]


def test_charts_of_bodies_are_in_seconds_and_of_tracks_that_grow_in_steps(physics: Track) -> None:
    for length, label, last in ((None, "seconds", physics.frames[-1].clock), (51, "step", 23)):
        scene = Scene([physics], make_figure, length=length)
        charts = scene.root.axes[1:6]
        assert [axes.get_title(loc="left").split(":")[0] for axes in charts] == [
            "Reward", "Distance (cells)", "Speed (m/s)", "Motor force (N)", "Energy used (J)"
        ]  # fmt: skip
        assert [axes.get_xlabel() for axes in charts] == ["", "", "", "", label]
        assert points(charts[0].lines[2])[-1][0] == last
        end = points(charts[4].lines[1])[-1]
        assert end == pytest.approx((last, physics.frames[-1].energy))
        assert max(speed for _, speed in points(charts[2].lines[1])) == pytest.approx(1.0)
        low, high = charts[0].get_xlim()
        assert low < 0 < last < high


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [([math.nan, 0.5], -1, 1), ([4, math.nan], -1, 4.4), ([-3, 7], -3.8, 7.8)],
)
def test_a_range_grows_with_a_margin_where_values_leave_it(
    values: list[float], low: float, high: float
) -> None:
    axes = make_figure((3, 2)).add_axes((0, 0, 1, 1))
    axes.set_ylim(-1, 1)
    fit(axes, values)
    assert axes.get_ylim() == pytest.approx((low, high))


def test_charts_are_those_that_have_something_to_show(physics: Track) -> None:
    still = Track([Frame(("..",), (), 0.0)], {"rewards": [0.0]})
    assert [*charts_of(still, [0.0])] == ["Reward"]
    assert [*charts_of(Track(still.frames, {}), [0.0])] == []


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
        shown: Any = axes.patches[1]
        assert (words.get_fontweight() == "bold") == (frame in (2, 3))
        found.append((shown.get_width(), words.get_text()))
    assert found == [
        (1, "battery 40 of 40"),
        (0.2, "battery 8 of 40"),
        (0.1975, "battery 7.9 of 40  LOW!"),
        (0, "battery 0 of 40  EMPTY!"),
        (0, "battery unknown"),
        (1, "battery 45 of 40"),
    ]
