"""Two tracks side by side in one figure: one clock, one scale, one legend."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from textwrap import fill
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.text import Text

from warehouse_core.render.palette import INK
from warehouse_core.viz.axes import box_in
from warehouse_core.viz.charts import BatteryBar, DistanceChart, MotionChart, RewardChart, TimeAxis
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.fleet_charts import FLEET_CHARTS
from warehouse_core.viz.grid_view import GridView, shown_size
from warehouse_core.viz.legend import draw_legend
from warehouse_core.viz.scene import MAX_CELL_INCHES, StepChart
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted

WIDTH, MARGIN, GUTTER = 13.66, 0.4, 0.5
"""Of the figure, at its sides and between its columns, in inches."""

LEAD_WIDTH = 8.0
"""Of the left column if it leads, in inches."""

MAX_MAP, MAX_LEAD_MAP, MAX_SMALL_MAP = 3.3, 4.8, 2.3
"""Heights of equal maps, of the map that leads and of the other one, in inches."""

HEAD, GAP, BAR, VERDICT, FOOT, FLEET_FOOT = 1.45, 0.1, 0.2, 0.45, 0.6, 0.8
"""Heights above and below maps, of the battery, the verdict and the legends, in inches."""

CHART, CHART_HEAD, CHART_FOOT, CHART_LEFT, CHART_RIGHT = 1.05, 0.3, 0.38, 0.4, 0.5
"""Height of a chart, and the room around it, in inches."""

BELOW = GAP + BAR + VERDICT

LEGEND_COLUMNS = 7

LETTER = 0.118
"""Mean width of a letter of a caption, in inches."""


class PairScene:
    """Two tracks side by side in one figure.

    If a motion is continuous and both have clocks, they are shown at the same simulated time, else
    after the same number of steps; the shorter one waits at its end. Maps and charts have the same
    scales. If only the left track has anything to chart, it leads: its map is larger, and its
    charts are on the right.

    Args:
        left: a track with at least one frame.
        right: another.
        make_figure: makes the figure of a width and height in inches.
    """

    def __init__(
        self, left: Track, right: Track, make_figure: Callable[[tuple[float, float]], SceneFigure]
    ) -> None:
        tracks = (left, right)
        has_bodies = left.is_continuous or right.is_continuous
        self._in_seconds = has_bodies and all(track.frames[-1].clock for track in tracks)
        self._times = [
            [frame.clock if self._in_seconds else frame.progress for frame in track.frames]
            for track in tracks
        ]
        self._moments = self._find_moments(tracks)
        places = _places_leading(left, right) if _leads(left, right) else _places_equal(tracks)
        is_fleet = left.is_fleet or right.is_fleet
        height = max(place.bottom for place in places) + (FLEET_FOOT if is_fleet else FOOT)
        self.root = make_figure((WIDTH, height))
        page = _Page(self.root, height)
        end = self._moments[-1]
        self._sides = [
            _Side(page, place, track, TimeAxis(end, track.clocks if self._in_seconds else None))
            for place, track in zip(places, tracks, strict=True)
        ]
        share_scales([side.charts for side in self._sides])
        self._clock = page.write(WIDTH / 2, 0.28, 18, ha="center")
        draw_legend(self.root, tracks, columns=LEGEND_COLUMNS)
        self.show(0)

    def __len__(self) -> int:
        return len(self._moments)

    def show(self, frame: int) -> None:
        """Show both tracks at the same moment."""
        moment = self._moments[frame]
        for times, side in zip(self._times, self._sides, strict=True):
            side.show(bisect_right(times, moment + 1e-9) - 1)
        self._clock.set_text(_seconds(moment) if self._in_seconds else f"step {moment:g}")

    def _find_moments(self, tracks: Sequence[Track]) -> list[float]:
        """Return the moments to show: each step, or times as close as the frames of a motion."""
        end = max(times[-1] for times in self._times)
        if not self._in_seconds:
            return sorted({*self._times[0], *self._times[1]})
        apart = min(
            track.frames[-1].clock / (len(track) - 1) for track in tracks if track.is_continuous
        )
        return [*(apart * number for number in range(math.ceil(end / apart - 1e-6))), end]


def share_scales(sides: Sequence[Sequence[Any]]) -> None:
    """Give charts of one kind the same vertical ranges, those that show the values of all.

    Args:
        sides: lists of charts; a chart may be in one list only.
    """
    kinds = {type(chart) for charts in sides for chart in charts}
    for kind in kinds:
        same = [chart.scales for charts in sides for chart in charts if type(chart) is kind]
        for scales in zip(*same, strict=True):
            lows, highs = zip(*(axes.get_ylim() for axes in scales), strict=True)
            for axes in scales:
                axes.set_ylim(min(lows), max(highs))


Box = tuple[float, float, float, float]
"""Left, top, width and height in inches, from the top left corner of the figure."""


class _Place(NamedTuple):
    """Where a track is drawn.

    Attributes:
        left: edge of its column, in inches.
        width: of its column, in inches.
        cell: side of a cell, in inches.
        below: lower edge of the room for its map, in inches from the top.
        charts: where its charts are, by their kinds.
        has_verdict: whether there is room for its battery and its verdict.
    """

    left: float
    width: float
    cell: float
    below: float
    charts: dict[type[StepChart], Box]
    has_verdict: bool = True

    @property
    def bottom(self) -> float:
        """Where its lowest part ends, in inches from the top."""
        charts = [top + height + CHART_FOOT for _, top, _, height in self.charts.values()]
        return max([self.below + self.has_verdict * BELOW, *charts])


def _leads(left: Track, right: Track) -> bool:
    """Return whether only the left track has anything to chart."""
    return bool(left.metrics) and not right.metrics and right.shift is None


def _places_equal(tracks: Sequence[Track]) -> list[_Place]:
    """Return columns of equal width with maps of one scale, and charts below them."""
    width = (WIDTH - GUTTER) / 2 - MARGIN
    cell = min(_cell(track, width, MAX_MAP) for track in tracks)
    below = HEAD + cell * max(shown_size(track)[1] for track in tracks)
    kinds = _kinds(tracks)
    places = []
    for left, track in zip((MARGIN, MARGIN + width + GUTTER), tracks, strict=True):
        boxes = [
            _chart_box(left + index % 2 * width / 2, below + BELOW, index // 2, width / 2)
            for index in range(len(kinds))
        ]
        charts = {
            kind: box for kind, box in zip(kinds, boxes, strict=True) if _can_draw(kind, track)
        }
        places.append(_Place(left, width, cell, below, charts))
    return places


def _places_leading(left: Track, right: Track) -> list[_Place]:
    """Return a wide column for the left track, and a narrow one that has its charts too."""
    edge = MARGIN + LEAD_WIDTH + GUTTER
    width = WIDTH - MARGIN - edge
    cells = _cell(left, LEAD_WIDTH, MAX_LEAD_MAP), _cell(right, width, MAX_SMALL_MAP)
    below = [
        HEAD + cell * shown_size(track)[1] for cell, track in zip(cells, (left, right), strict=True)
    ]
    charts = {
        kind: _chart_box(edge, below[1], row, width) for row, kind in enumerate(_kinds([left]))
    }
    return [
        _Place(MARGIN, LEAD_WIDTH, cells[0], below[0], charts),
        _Place(edge, width, cells[1], below[1], {}, has_verdict=False),
    ]


def _cell(track: Track, width: float, height: float) -> float:
    columns, rows = shown_size(track)
    return min(width / columns, height / rows, MAX_CELL_INCHES)


def _chart_box(left: float, top: float, row: int, width: float) -> Box:
    top += CHART_HEAD + row * (CHART_HEAD + CHART + CHART_FOOT)
    return left + CHART_LEFT, top, width - CHART_LEFT - CHART_RIGHT, CHART


def _kinds(tracks: Sequence[Track]) -> list[type[StepChart]]:
    """Return the kinds of charts: of fleets, or rewards and either energy or distances."""
    if any(track.shift for track in tracks):
        return [*FLEET_CHARTS]
    has_motion = any(track.is_continuous for track in tracks)
    kinds: list[type[StepChart]] = [RewardChart, MotionChart if has_motion else DistanceChart]
    return [kind for kind in kinds if any(_can_draw(kind, track) for track in tracks)]


def _can_draw(kind: type[StepChart], track: Track) -> bool:
    """Return whether a track has what a kind of chart shows."""
    if kind is RewardChart:
        return "rewards" in track.metrics
    if kind is DistanceChart:
        return not track.metrics.keys().isdisjoint(DistanceChart.NAMES.values())
    if kind is MotionChart:
        return track.is_continuous or track.frames[-1].energy > 0
    return track.shift is not None


class _Page:
    """Puts axes and texts into a figure, at places in inches from the top left corner."""

    def __init__(self, figure: SceneFigure, height: float) -> None:
        self.figure, self._size = figure, (WIDTH, height)

    def axes(self, *box: float) -> Axes:
        """Add axes with a left and top edge, a width and a height."""
        left, top, width, height = box
        return self.figure.add_axes(box_in(self._size, left, top, width, height))

    def write(self, left: float, top: float, size: float, **options: Any) -> Text:
        """Add a text, empty so far, of a size in points."""
        at = left / self._size[0], 1 - top / self._size[1]
        style: dict[str, Any] = {"fontweight": "bold", "color": INK, "va": "center"} | options
        text = self.figure.text(*at, "", fontsize=size, parse_math=False, **style)
        self.figure.add_mover(text)
        return text


class _Side:
    """One of the two tracks: its title, caption, map, battery, verdict and charts."""

    def __init__(self, page: _Page, place: _Place, track: Track, time: TimeAxis) -> None:
        self._track = track
        figure = page.figure
        width, height = (place.cell * cells for cells in shown_size(track))
        axes = page.axes(place.left, HEAD, width, height)
        self._grid = GridView(figure, axes, place.cell * 72, track)
        self._bars = list[BatteryBar]()
        if "battery" in track.metrics:
            axes = page.axes(place.left, place.below + GAP, width, BAR)
            self._bars.append(BatteryBar(figure, axes))
        self.charts: list[StepChart] = []
        for kind, box in place.charts.items():
            axes = page.axes(*box)
            self.charts.append(kind(figure, axes, track, time))
            axes.set_xlabel(time.label, fontsize=8, labelpad=1)
        self._letters = int(place.width / LETTER)
        page.write(place.left, 0.62, 11, fontweight="normal").set_text(track.title)
        self._caption = page.write(place.left, 0.77, 13, va="top")
        self._verdict = page.write(place.left, place.below + BELOW - VERDICT / 2, 15)
        self._verdict.set_visible(place.has_verdict)

    def show(self, frame: int) -> None:
        """Show a frame of the track."""
        track, now = self._track, self._track.frames[frame]
        self._grid.show_tiles(now.tiles)
        self._grid.show_robots(track.frames, frame)
        self._grid.show_route(now.route)
        self._grid.show_hits(now.hits)
        for chart in (*self._bars, *self.charts):
            chart.show(track, frame)
        self._caption.set_text(fill(now.caption, self._letters, max_lines=2, placeholder=" …"))
        self._verdict.set_text(_tally(track, frame))


def _tally(track: Track, frame: int) -> str:
    """Return the steps, seconds and joules so far; at the end, a verdict with the outcome."""
    now, shift, step = track.frames[frame], track.shift, track.step_at(frame)
    numbers = [f"{shift.delivered[step]} delivered"] if shift else []
    numbers.append(counted(math.ceil(now.progress), "step"))
    if track.frames[-1].clock:
        numbers += [_seconds(now.clock), f"{shift.joules[step] if shift else now.energy:,.0f} J"]
    words = ", ".join(numbers)
    is_over = frame == len(track) - 1
    return f"{track.ending.capitalize()}: {words}" if is_over and track.ending else words


def _seconds(clock: float) -> str:
    """Return a sum of seconds to one decimal, rounded as if it was exact."""
    return f"{round(clock, 6):.1f} s"
