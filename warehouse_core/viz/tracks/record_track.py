"""What a replay of a record draws, of one robot or of a fleet."""

from __future__ import annotations

from collections.abc import Sequence

from warehouse_core.records.episode import Episode, FleetEpisode
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.tracks.episode_track import track_of_episode
from warehouse_core.viz.tracks.fleet_track import track_of_fleet_episode
from warehouse_core.viz.tracks.motion_frames import FRAME_SECONDS
from warehouse_core.viz.tracks.track import Track

Record = Episode | FleetEpisode


def track_of_record(
    record: Record,
    frame_seconds: float | None = FRAME_SECONDS,
    plans: Sequence[StepPlans] = (),
) -> Track:
    """Return what ``track_of_episode`` or, with ``plans``, ``track_of_fleet_episode`` returns."""
    if record.is_fleet:
        return track_of_fleet_episode(record, frame_seconds, plans)
    return track_of_episode(record, frame_seconds)
