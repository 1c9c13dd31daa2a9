"""Tracks, which contain everything that a replay shows, from records or from bare frames.

This package imports nothing that takes long to import.
"""

from warehouse_core.viz.tracks.grid_track import track_of_frames
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Frame, Pose, Track

__all__ = ["Frame", "Pose", "Track", "track_of_frames", "track_of_record"]
