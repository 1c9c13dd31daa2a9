"""Two tracks side by side in one figure, under one legend."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import partial
from typing import Any

from matplotlib.figure import SubFigure

from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.legend import draw_legend
from warehouse_core.viz.scene import FOOT, MARGIN, Plan, Scene
from warehouse_core.viz.tracks.track import Track


class PairScene:
    """Two tracks side by side in one figure, under one legend.

    Two continuous tracks are shown at the same simulated time, others at the same step.

    Args:
        left: a track with at least one frame.
        right: another; the shorter one waits at its end.
        make_figure: makes the figure of a width and height in inches.
    """

    def __init__(
        self, left: Track, right: Track, make_figure: Callable[[tuple[float, float]], SceneFigure]
    ) -> None:
        tracks = (left, right)
        body = max(Plan(track, MARGIN).body_height for track in tracks)
        sizes = [Plan(track, MARGIN, body).size for track in tracks]
        width, height = sizes[0][0] + sizes[1][0], max(size[1] for size in sizes)
        self.root = make_figure((width, height + FOOT))
        halves: Any = self.root.subfigures(2, 1, height_ratios=[height, FOOT])
        top, bottom = halves
        parts = top.subfigures(1, 2, width_ratios=[size[0] for size in sizes])
        length = max(left.steps, right.steps) + 1
        by_clock = left.is_continuous and right.is_continuous
        self._times = [
            [frame.clock if by_clock else frame.progress for frame in track.frames]
            for track in tracks
        ]
        self._scenes = [
            Scene(
                track, partial(_given, part),
                length=length, height=height, body=body, legend=False,
            )
            for track, part in zip(tracks, parts, strict=True)
        ]  # fmt: skip
        self._moments = sorted({*self._times[0], *self._times[1]})
        draw_legend(bottom, [left, right], columns=6)

    def __len__(self) -> int:
        return len(self._moments)

    def show(self, frame: int) -> None:
        """Show both tracks at the same moment."""
        for times, scene in zip(self._times, self._scenes, strict=True):
            scene.show(bisect_right(times, self._moments[frame]) - 1)


def _given(part: SubFigure, size: tuple[float, float]) -> SubFigure:
    """Return a part of a figure that exists already, as a ``MakeFigure``."""
    return part
