"""Figures and animations, by matplotlib. The track of a replay is here; the rest is heavy."""

from warehouse_core.viz.fleet_track import track_of_fleet_episode
from warehouse_core.viz.track import Frame, Pose, Track, track_of_episode, track_of_frames

__all__ = [
    "Frame",
    "Pose",
    "Track",
    "track_of_episode",
    "track_of_fleet_episode",
    "track_of_frames",
]
