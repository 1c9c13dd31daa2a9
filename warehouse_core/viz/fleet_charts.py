"""The charts beside a fleet: deliveries, lateness, and batteries with energy."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from warehouse_core.render.palette import BATTERY, FAINT, INK, WARNING
from warehouse_core.viz.charts import TimeAxis, fit, prepare
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.track import Shift, Track

DATA_COLOR = "0.45"


def _shift_of(track: Track) -> Shift:
    assert track.shift is not None, "only tracks of fleets have these charts"
    return track.shift


class DeliveryChart:
    """Orders released and delivered so far."""

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        prepare(axes, "orders delivered (thin line: released)", time)
        self._time, self.scales = time, (axes,)
        axes.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
        style: dict[str, Any] = {"color": INK, "drawstyle": "steps-post"}
        self._released = axes.plot([], [], linewidth=0.8, **style)[0]
        self._delivered = axes.plot([], [], linewidth=2.2, **style)[0]
        for mover in (self._released, self._delivered):
            figure.add_mover(mover)
        shift = _shift_of(track)
        axes.set_ylim(0, 1)
        fit(axes, [shift.released[-1], shift.delivered[-1]])

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of ``frame``."""
        times, shift = self._time.of_steps(track.step_at(frame)), _shift_of(track)
        self._released.set_data(times, shift.released[: len(times)])
        self._delivered.set_data(times, shift.delivered[: len(times)])


class LatenessChart:
    """By how many steps each delivery was late; dots on time, triangles late."""

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        prepare(axes, "lateness of each delivery (steps; ▲ late)", time)
        self._time, self.scales = time, (axes,)
        axes.axhline(0, color=INK, linewidth=0.8, zorder=0)
        style: dict[str, Any] = {"linestyle": "none", "markeredgewidth": 0}
        self._on_time = axes.plot([], [], marker="o", markersize=3.5, color=BATTERY, **style)[0]
        self._late = axes.plot([], [], marker="^", markersize=5.5, color=WARNING, **style)[0]
        for mover in (self._on_time, self._late):
            figure.add_mover(mover)
        axes.set_ylim(-1, 1)
        fit(axes, [late for _, late in _shift_of(track).lateness])

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of ``frame``."""
        last = track.step_at(frame)
        times, lateness = self._time.of_steps(last), _shift_of(track).lateness
        shown = [(times[step], late) for step, late in lateness if step <= last]
        for line, is_late in ((self._on_time, False), (self._late, True)):
            points = [point for point in shown if (point[1] > 0) == is_late]
            line.set_data([x for x, _ in points], [late for _, late in points])


class EnergyChart:
    """The batteries as lines, and the energy used so far as an area with its own scale."""

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        prepare(axes, "battery (%; thin line: lowest) and energy (kJ, area)", time)
        energy = axes.twinx()
        self._time, self.scales = time, (axes, energy)
        energy.set_zorder(axes.get_zorder() - 1)
        axes.patch.set_visible(False)
        energy.spines[:].set_visible(False)
        energy.tick_params(labelsize=7, labelcolor=DATA_COLOR, length=0, pad=1)
        energy.yaxis.set_major_locator(MaxNLocator(nbins=3))
        self._area = Polygon([(0, 0), (0, 0)], closed=True, facecolor=FAINT, linewidth=0)
        energy.add_patch(self._area)
        self._mean = axes.plot([], [], color=BATTERY, linewidth=2.2)[0]
        self._lowest = axes.plot([], [], color=WARNING, linewidth=0.9)[0]
        for mover in (self._area, self._mean, self._lowest):
            figure.add_mover(mover)
        axes.set_ylim(0, 105)
        energy.set_ylim(0, max(1.0, 1.08e-3 * _shift_of(track).joules[-1]))

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of ``frame``."""
        times, shift = self._time.of_steps(track.step_at(frame)), _shift_of(track)
        count = len(times)
        self._mean.set_data(times, [100 * share for share in shift.battery[:count]])
        self._lowest.set_data(times, [100 * share for share in shift.lowest[:count]])
        edge = zip(times, (joules / 1000 for joules in shift.joules), strict=False)
        self._area.set_xy([(0.0, 0.0), *edge, (times[-1], 0.0)])


FLEET_CHARTS = (DeliveryChart, LatenessChart, EnergyChart)
