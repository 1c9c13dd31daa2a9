"""A whole picture: warehouses with their charts, batteries and words, and one legend."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from matplotlib.axes import Axes
from matplotlib.text import Text

from warehouse_core.render.palette import INK
from warehouse_core.viz.axes.look import POINTS, box_in
from warehouse_core.viz.charts import BatteryBar, Chart, TimeAxis, share_scales
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.legend import draw_legend, signs_of
from warehouse_core.viz.sheet import BOLD, WIDTH, Box, Sheet, TrackPlace, sheet_of
from warehouse_core.viz.tracks.timeline import Timeline
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import View


class Scene:
    """Tracks drawn into one figure, one moment at a time.

    Several tracks are side by side: with one clock, scales that can be compared, and one legend.

    Args:
        tracks: tracks, at least one, each with at least one frame.
        make_figure: function that makes the figure of a width and height in inches.
        length: number of steps plus one to leave room for, where a single track is still growing.
        legend: draw the legend.
    """

    def __init__(
        self,
        tracks: Sequence[Track],
        make_figure: Callable[[tuple[float, float]], SceneFigure],
        *,
        length: int | None = None,
        legend: bool = True,
    ) -> None:
        self._timeline = Timeline(tracks)
        steps = length - 1 if length else tracks[0].steps
        sheet = sheet_of(tracks, steps, legend=legend)
        self.root = make_figure(sheet.size)
        page = SheetFigure(self.root, sheet)
        self._panels = [
            Panel(page, place, track, TimeAxis(steps) if length else self._axis_of(track), steps)
            for place, track in zip(sheet.places, tracks, strict=True)
        ]
        self._clock: Text | None = None
        if len(tracks) > 1:
            share_scales([chart for panel in self._panels for chart in panel.charts])
            self._clock = page.write(WIDTH / 2, 0.28, fontsize=18, ha="center", **BOLD)
        self._draw_legend = partial(draw_legend, self.root, columns=sheet.legend_columns)
        self._legend = self._draw_legend(tracks) if legend else None
        self.show(0)

    def __len__(self) -> int:
        return len(self._timeline.moments)

    def _axis_of(self, track: Track) -> TimeAxis:
        """Return the horizontal axis of the charts of a track."""
        timeline = self._timeline
        return TimeAxis(timeline.moments[-1], track.clocks if timeline.in_seconds else None)

    @property
    def still(self) -> int:
        """The moment of a picture that does not move."""
        return self._timeline.still

    def show(self, number: int, grown: Track | None = None) -> None:
        """Move everything that moves to its place at a moment, of a track that may have grown."""
        if grown is not None and grown is not self._panels[0].track:
            self._timeline = Timeline([grown])
            self._panels[0].track = grown
            self._explain(grown)
        for panel, frame in zip(self._panels, self._timeline.frames_at(number), strict=True):
            panel.show(frame)
        if self._clock is not None:
            self._clock.set_text(self._timeline.words(number))

    def _explain(self, track: Track) -> None:
        """Draw the legend again, if there is one and a track has other signs than it explains."""
        legend = self._legend
        if legend and [*signs_of(track)] != [text.get_text() for text in legend.get_texts()]:
            legend.remove()
            self._legend = self._draw_legend([track])


class SheetFigure:
    """A figure into which axes and words are put by their places on a sheet."""

    def __init__(self, figure: SceneFigure, sheet: Sheet) -> None:
        self.figure, self.sheet = figure, sheet

    def axes(self, box: Box) -> Axes:
        """Add axes."""
        return self.figure.add_axes(box_in(self.sheet.size, *box))

    def write(self, left: float, top: float, **style: Any) -> Text:
        """Add words, none so far."""
        width, height = self.sheet.size
        style = {"color": INK, "va": "center"} | style
        text = self.figure.text(left / width, 1 - top / height, "", parse_math=False, **style)
        self.figure.add_mover(text)
        return text


class Panel:
    """One of the tracks of a picture: its map, charts, battery and words.

    The charts have room for a number of steps.
    """

    def __init__(
        self, page: SheetFigure, place: TrackPlace, track: Track, time: TimeAxis, steps: int
    ) -> None:
        self.track, self._steps = track, steps
        self._parts = page.sheet.motion_parts
        self._view = View(page.figure, page.axes(place.map), place.cell * POINTS, track)
        self.charts: list[Chart | BatteryBar] = []
        for kind, box, has_label in place.slots:
            chart = kind(page.figure, page.axes(box), track, time)
            self.charts.append(chart)
            if has_label and not isinstance(chart, BatteryBar):
                chart.label_time()
        self._lines = [
            (say, page.write(left, top, **style)) for left, top, say, style in place.lines
        ]
        self._charted: tuple[int, int, int] | None = None

    def show(self, frame: int) -> None:
        """Show a frame of the track."""
        track = self.track
        self._view.show(track.frames, frame)
        charted = self._first_like(frame)
        before, self._charted = self._charted, (track.step_at(frame), len(track), charted)
        for chart in self.charts:
            depth = 3 if chart.changes_within_steps else 2
            if before is None or before[:depth] != self._charted[:depth]:
                chart.show(track, charted)
        for say, text in self._lines:
            words, size = say(track, frame)
            if words != text.get_text():
                text.set(text=words, fontsize=size)

    def _first_like(self, frame: int) -> int:
        """Return the first of the frames whose charts look the same as in a frame."""
        if self._parts is None:
            return frame
        parts, length = self._parts, self._steps + 1

        def place(number: int) -> tuple[int, int]:
            progress = self.track.frames[number].progress
            return math.floor(progress), math.floor(progress * parts / length)

        while frame and place(frame - 1) == place(frame):
            frame -= 1
        return frame
