"""A complete picture: one or more warehouses with charts, batteries and text, and one legend."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.text import Text

from warehouse_core.viz.axes import POINTS, box_in
from warehouse_core.viz.charts import BatteryBar, Chart, Charted, charts_of, share_scales
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.legend import draw_legend, signs_of
from warehouse_core.viz.sheet import BOLD, WIDTH, Box, Sheet, TrackPlace, sheet_of
from warehouse_core.viz.tracks.timeline import Timeline, time_of
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import View


class Scene:
    """Tracks drawn into one figure, one moment at a time.

    Several tracks are shown side by side, with one clock, comparable scales and one legend.

    Args:
        tracks: tracks, at least one, each with at least one frame.
        make_figure: function that returns a figure of a given width and height in inches.
        length: final number of steps plus one, for a single track that is still growing.
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
        self._in_seconds = self._timeline.in_seconds and not length
        charts = [self._charts_of(track) for track in tracks]
        sheet = sheet_of(tracks, [[*each] for each in charts], steps, legend=legend)
        self.root = make_figure(sheet.size)
        end = steps if length else self._timeline.moments[-1]
        label = "seconds" if self._in_seconds else "step"
        self._panels = [
            Panel(self.root, sheet, place, track, each, end, label)
            for place, track, each in zip(sheet.places, tracks, charts, strict=True)
        ]
        self._clock: Text | None = None
        if len(tracks) > 1:
            share_scales(chart for panel in self._panels for chart in panel.charts)
            self._clock = self.root.add_text(WIDTH / 2, 0.28, fontsize=18, ha="center", **BOLD)
        self._draw_legend = partial(draw_legend, self.root, columns=sheet.legend_columns)
        self._legend = self._draw_legend(tracks) if legend else None
        self.show(0)

    def __len__(self) -> int:
        return len(self._timeline.moments)

    def _charts_of(self, track: Track) -> Charted:
        times = [time_of(frame, in_seconds=self._in_seconds) for frame in track.frames]
        return charts_of(track, times)

    @property
    def still(self) -> int:
        """Number of the moment that a still picture shows."""
        return self._timeline.still

    def show(self, number: int, grown: Track | None = None) -> None:
        """Show the moment with this number; ``grown`` is the new version of a growing track."""
        if grown is not None and grown is not self._panels[0].track:
            self._timeline = Timeline([grown])
            self._panels[0].read(grown, self._charts_of(grown))
            self._explain(grown)
        for panel, frame in zip(self._panels, self._timeline.frames_at(number), strict=True):
            now = panel.track.frames[frame]
            panel.show(frame, time_of(now, in_seconds=self._in_seconds))
        if self._clock is not None:
            self._clock.set_text(self._timeline.words(number))

    def toggle_arrows(self) -> None:
        """Hide or show the arrows of bodies, from the next ``show`` on."""
        for panel in self._panels:
            panel.view.has_arrows = not panel.view.has_arrows

    def _explain(self, track: Track) -> None:
        """Redraw the legend, if there is one and the signs of the track have changed."""
        legend = self._legend
        if legend and [*signs_of(track)] != [text.get_text() for text in legend.get_texts()]:
            legend.remove()
            self._legend = self._draw_legend([track])


class Panel:
    """One track of a picture: its map, charts, battery and text.

    The time axes of its charts end at ``end`` and have a ``label``.
    """

    def __init__(
        self,
        figure: SceneFigure,
        sheet: Sheet,
        place: TrackPlace,
        track: Track,
        charted: Charted,
        end: float,
        label: str,
    ) -> None:
        self.track = track

        def axes_in(box: Box) -> Axes:
            return figure.add_axes(box_in(sheet.size, *box))

        self.view = View(figure, axes_in(place.map), place.cell * POINTS, track)
        self.charts = []
        for title, box in place.charts.items():
            is_labelled = not sheet.labels_last or title == [*place.charts][-1]
            words = label if is_labelled else None
            self.charts.append(Chart(figure, axes_in(box), charted[title], end, label=words))
        self._bar = BatteryBar(figure, axes_in(place.bar)) if place.bar else None
        self._lines = [
            (say, figure.add_text(left, top, **style)) for left, top, say, style in place.lines
        ]

    def read(self, track: Track, charted: Charted) -> None:
        """Replace the track by a longer version of itself."""
        self.track = track
        for chart in self.charts:
            chart.read(charted[chart.title])

    def show(self, frame: int, time: float) -> None:
        """Show a frame of the track, and its time in the charts."""
        self.view.show(self.track.frames, frame)
        for chart in self.charts:
            chart.show(time)
        if self._bar:
            self._bar.show(self.track, frame)
        for say, text in self._lines:
            words, size = say(self.track, frame)
            if words != text.get_text():
                text.set(text=words, fontsize=size)
