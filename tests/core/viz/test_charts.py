"""The axes of charts."""

import pytest
from matplotlib.axes import Axes
from matplotlib.text import Text

from agents.run_episode import run_episode
from warehouse_core.viz.charts import RewardChart, TimeAxis
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track


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
