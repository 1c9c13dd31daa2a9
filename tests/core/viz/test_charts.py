"""The axes of charts, and what is drawn into them."""

import math
from typing import Any

import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.text import Text

from agents.run_episode import run_episode
from warehouse_core.viz.charts import (
    BatteryBar,
    DeliveryChart,
    DistanceChart,
    EnergyChart,
    LatenessChart,
    MotionChart,
    RewardChart,
    TimeAxis,
    fit,
    kinds_of_charts,
    share_scales,
)
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Track

CLOCKS = [0.0, 1.5, 2.5, 4.0]
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


def axes_of(scene: Scene, title: str) -> Axes:
    [found] = [axes for axes in scene.root.axes if title in axes.get_title(loc="left")]
    return found


def test_charts_of_bodies_are_in_seconds(physics: Track) -> None:
    scene = Scene([physics], make_figure)
    scene.show(len(physics) - 1)
    rewards, motion = axes_of(scene, "reward"), axes_of(scene, "energy")
    assert motion.get_xlabel() == "seconds"
    low, high = rewards.get_xlim()
    assert -2 < low < 0
    assert 49.75 < high < 52
    assert list(rewards.lines[1].get_xdata()) == physics.clocks  # type: ignore[arg-type]
    assert list(motion.lines[0].get_xdata()) == [f.clock for f in physics.frames]  # type: ignore[arg-type]


def test_the_clock_of_one_robot_has_the_decimal_of_the_others(physics: Track) -> None:
    scene = Scene([physics], make_figure)
    scene.show(len(physics) - 1)
    assert "step 23 of 23   49.8 s" in [text.get_text() for text in scene.root.findobj(Text)]


def test_speed_and_energy_begin_at_0_and_fill_the_chart(physics: Track) -> None:
    scene = Scene([physics], make_figure)
    scene.root.pixels()
    motion, energy = axes_of(scene, "energy"), scene.root.axes[-2]
    assert motion.get_ylim()[0] == energy.get_ylim()[0] == 0
    most = physics.frames[-1].energy
    assert most < energy.get_ylim()[1] < 1.1 * most
    assert all(label.get_text().endswith("J") for label in energy.get_yticklabels())


def test_charts_of_a_track_that_grows_are_in_steps(physics: Track) -> None:
    scene = Scene([physics], make_figure, length=51)
    rewards = axes_of(scene, "reward")
    assert rewards.get_xlim() == (-0.5, 50.5)
    scene.show(len(physics) - 1)
    assert list(rewards.lines[1].get_xdata()) == list(range(24))  # type: ignore[arg-type]


def test_rewards_are_drawn_at_the_clock_of_their_step(physics: Track) -> None:
    figure = make_figure((3, 2))
    axes = figure.add_axes((0, 0, 1, 1))
    chart = RewardChart(figure, axes, physics, TimeAxis(physics.frames[-1].clock, physics.clocks))
    chart.show(physics, len(physics) - 1)
    [bars] = axes.collections
    starts = [segment[0][0] for segment in bars.get_segments()]  # type: ignore[attr-defined]
    assert starts == physics.clocks


def fleet(**metrics: Any) -> Track:
    """Return three steps of a fleet, whose two first deliveries are in time."""
    lateness = [(2, -4), (2, 0), (3, 7)]
    frames = [
        Frame(("..",), (), float(step), clock=clock, fleet=FleetFrame((), (), ()))
        for step, clock in enumerate(CLOCKS)
    ]
    return Track(frames, METRICS | metrics, lateness=lateness)


def drawn(
    kind: Any, track: Track, frame: int, *, in_seconds: bool = False
) -> tuple[Any, Axes, list[tuple[list[float], list[float]]]]:
    """Return a chart, its axes, and the points of its lines, after it has shown a frame."""
    figure = make_figure((3, 2))
    axes = figure.add_axes((0, 0, 1, 1))
    chart = kind(figure, axes, track, TimeAxis(4, CLOCKS if in_seconds else None))
    chart.show(track, frame)
    return chart, axes, [([*line.get_xdata()], [*line.get_ydata()]) for line in axes.lines]


@pytest.mark.parametrize("in_seconds", [False, True])
def test_orders_of_a_fleet_are_counted_up_to_the_frame(in_seconds: bool) -> None:
    times = CLOCKS if in_seconds else [0, 1, 2, 3]
    chart, axes, lines = drawn(DeliveryChart, fleet(), 2, in_seconds=in_seconds)
    assert lines == [(times[:3], [1, 3, 4]), (times[:3], [0, 0, 2])]
    released, delivered = axes.lines
    assert released.get_linewidth() < delivered.get_linewidth()
    assert {line.get_drawstyle() for line in axes.lines} == {"steps-post"}
    low, high = axes.get_ylim()
    assert low == 0
    assert 4 < high < 5, "all orders have room from the first frame on"
    chart.label_time()
    assert axes.get_xlabel() == ("seconds" if in_seconds else "step")
    low, high = axes.get_xlim()
    assert -0.6 < low < 0
    assert 4 < high < 4.6


def test_deliveries_in_time_are_dots_and_late_ones_triangles() -> None:
    _, axes, lines = drawn(LatenessChart, fleet(), 3, in_seconds=True)
    zero, in_time, late = lines
    assert zero[1] == [0, 0]
    assert (in_time, late) == (([2.5, 2.5], [-4, 0]), ([4.0], [7]))
    assert [line.get_marker() for line in axes.lines[1:]] == ["o", "^"]
    low, high = axes.get_ylim()
    assert -6 < low < -4
    assert 7 < high < 9
    assert drawn(LatenessChart, fleet(), 2)[2][1:] == [([2, 2], [-4, 0]), ([], [])]
    assert drawn(LatenessChart, fleet(), 1)[2][1:] == [([], [])] * 2


def test_batteries_are_in_percent_and_energy_in_kilojoules() -> None:
    chart, axes, lines = drawn(EnergyChart, fleet(), 2)
    assert [line[1] for line in lines] == [pytest.approx([100, 90, 80]), [100, 80, 50]]
    mean, lowest = axes.lines
    assert mean.get_linewidth() > lowest.get_linewidth()
    low, high = axes.get_ylim()
    assert low == 0
    assert 100 < high < 110
    _, behind = chart.scales
    assert behind.get_zorder() < axes.get_zorder()
    low, high = behind.get_ylim()
    assert low == 0
    assert 5 < high < 6
    [area] = behind.patches
    assert isinstance(area, Polygon)
    assert area.get_xy()[:-1].tolist() == [[0, 0], [0, 0], [1, 1], [2, 2.5], [2, 0]]
    _, behind = drawn(EnergyChart, fleet(joules=[0, 0, 0, 1]), 2)[0].scales
    assert behind.get_ylim() == (0, 1)


def test_energy_and_speed_are_drawn_up_to_the_frame(physics: Track) -> None:
    frames = physics.frames[:10]
    clocks = [each.clock for each in frames]
    chart, _, [line] = drawn(MotionChart, physics, 9, in_seconds=True)
    [area] = chart.scales[1].patches
    edge = [*zip(clocks, [each.energy for each in frames], strict=True)]
    assert [*map(tuple, area.get_xy())][:-1] == [(0, 0), *edge, (clocks[-1], 0)]
    assert line == (clocks, [each.speed for each in frames])


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [
        ([], -1, 1),
        ([math.nan, 0.5], -1, 1),
        ([-1, 1], -1, 1),
        ([4, math.nan], -1, 4.4),
        ([-4], -4.4, 1),
        ([-3, 7], -3.8, 7.8),
    ],
)
def test_a_range_grows_with_a_margin_where_values_leave_it(
    values: list[float], low: float, high: float
) -> None:
    axes = make_figure((3, 2)).add_axes((0, 0, 1, 1))
    axes.set_ylim(-1, 1)
    fit(axes, values)
    assert axes.get_ylim() == pytest.approx((low, high))


def test_charts_of_one_kind_share_both_ranges() -> None:
    tracks = fleet(), fleet(joules=[0, 0, 0, 20_000], released=[0, 0, 0, 99])
    first, second, other = charts = [
        drawn(kind, track, 3)[0]
        for kind, track in ((EnergyChart, tracks[0]), (EnergyChart, tracks[1]),
                            (DeliveryChart, tracks[1]))
    ]  # fmt: skip
    first.scales[0].set_ylim(-20, 50)
    share_scales(charts)
    for chart in (first, second):
        assert [axes.get_ylim() for axes in chart.scales] == [
            pytest.approx((-20, 105)), pytest.approx((0, 21.6))
        ]  # fmt: skip
    low, high = other.scales[0].get_ylim()
    assert (low, high > 99) == (0, True)


def test_the_kinds_of_charts_are_those_that_have_something_to_show(physics: Track) -> None:
    bare = Track(physics.frames, {})
    still = Track([Frame(("..",), (), 0.0)], {"rewards": [0.0]})
    assert kinds_of_charts([physics]) == [RewardChart, DistanceChart, MotionChart]
    assert kinds_of_charts([still]) == [RewardChart]
    assert kinds_of_charts([still, physics]) == [RewardChart, DistanceChart, MotionChart]
    assert kinds_of_charts([bare]) == []
    assert kinds_of_charts([still, fleet()]) == [DeliveryChart, LatenessChart, EnergyChart]
    moving = Frame(("..",), (), 1.0, energy=3.0)
    assert MotionChart.can_draw(Track([*still.frames, moving], {}))
    assert not MotionChart.can_draw(still)


def test_a_battery_has_a_bar_of_its_level_and_words_that_warn() -> None:
    levels = [40.0, 8.0, 7.9, 0.0, math.nan, 45.0]
    frames = [Frame(("..",), (), float(step)) for step in range(len(levels))]
    track = Track(frames, {"battery": levels}, full_battery=40.0)
    widths = []
    for frame in range(len(levels)):
        _, axes, _ = drawn(BatteryBar, track, frame)
        paper, bar = axes.patches
        assert paper.get_bbox().bounds == pytest.approx((0, bar.get_y(), 1, bar.get_height()))
        [words] = axes.texts
        assert words.get_position()[0] > 1, "beside the bar"
        is_low = "!" in words.get_text()
        assert (words.get_fontweight() == "bold") == is_low
        widths.append((bar.get_width(), is_low))
    assert widths == [(1, False), (0.2, False), (0.1975, True), (0, True), (0, False), (1, False)]
