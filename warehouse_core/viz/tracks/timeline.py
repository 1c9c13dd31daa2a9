"""The sequence of moments in which one or more tracks are shown together."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence

from warehouse_core.viz.tracks.track import Frame, Point, Track
from warehouse_core.wording import seconds_of


class Timeline:
    """The sequence of moments in which one or more tracks are shown together.

    A single track is shown frame by frame. Several tracks are shown at the same simulated time if
    all have clocks and at least one has continuous motions, and otherwise after the same number of
    steps. A track that ends earlier stays at its end. The clocks of searches count expansions.

    Attributes:
        in_seconds: true if moments are times of clocks, false if they are steps.
        moments: moments in ascending order; the last one is the end.
    """

    def __init__(self, tracks: Sequence[Track]) -> None:
        self._tracks = tracks
        has_clock = any(track.is_continuous or track.marks is not None for track in tracks)
        self.in_seconds = has_clock and all(track.frames[-1].clock for track in tracks)
        self._times = [
            [time_of(frame, in_seconds=self.in_seconds) for frame in track.frames]
            for track in tracks
        ]
        self.moments = self._times[0] if len(tracks) == 1 else self._find_moments(tracks)

    @property
    def still(self) -> int:
        """Number of the moment that a still picture shows; for several tracks this is the end."""
        return self._tracks[0].still if len(self._tracks) == 1 else len(self.moments) - 1

    def frames_at(self, number: int) -> list[int]:
        """Return the frame of each track at a moment."""
        if len(self._times) == 1:
            return [number]
        moment = self.moments[number]
        return [bisect_right(times, moment + 1e-9) - 1 for times in self._times]

    def words(self, number: int) -> str:
        """Return the moment with this number in words."""
        moment = self.moments[number]
        if self._tracks[0].marks is not None:
            return f"after {moment:.0f} of {self.moments[-1]:.0f} expansions"
        return f"{seconds_of(moment)} s" if self.in_seconds else f"step {moment:g}"

    def _find_moments(self, tracks: Sequence[Track]) -> list[float]:
        """Return all steps, or times that are as close together as the frames of the motions."""
        end = max(times[-1] for times in self._times)
        if not self.in_seconds:
            return sorted({moment for times in self._times for moment in times})
        moving = [track for track in tracks if track.is_continuous] or tracks
        apart = max(track.frames[-1].clock / (len(track) - 1) for track in moving)
        return [*(apart * number for number in range(math.ceil(end / apart - 1e-6))), end]


def ghost_of(track: Track, other: Track) -> list[Point]:
    """Return where the robot of ``other`` is in each frame of ``track``, on their common clock.

    Both are tracks of a single robot; see ``Timeline``. The result is meant for ``Track.ghost``.
    """
    in_seconds = Timeline([track, other]).in_seconds
    times = [time_of(frame, in_seconds=in_seconds) for frame in other.frames]
    poses = [frame.robots[0] for frame in other.frames]
    found = []
    for frame in track.frames:
        moment = time_of(frame, in_seconds=in_seconds)
        pose = poses[bisect_right(times, moment + 1e-9) - 1]
        assert pose is not None, "a record has a pose of its robot in each frame"
        found.append(pose.at)
    return found


def time_of(frame: Frame, *, in_seconds: bool) -> float:
    """Return the time of a frame, in seconds of its clock or in steps."""
    return frame.clock if in_seconds else frame.progress
