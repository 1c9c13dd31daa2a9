"""Records of episodes, their files, and failure modes.

Example:
    >>> from warehouse_core.records import FLEET_MODES, MODES
    >>> "oscillation" in MODES, "deadlock" in FLEET_MODES
    (True, True)
"""

from warehouse_core.records.drive_summary import DriveSummary, drive_summary
from warehouse_core.records.episode import Episode, FleetEpisode
from warehouse_core.records.failure_modes import (
    FLEET_MODES,
    MODES,
    Diagnosis,
    diagnose,
)
from warehouse_core.records.recorder import (
    Agent,
    EpisodeRecorder,
    FleetAgent,
    FleetRecorder,
    record_episode,
    record_fleet_episode,
    replay_episode,
    replay_fleet_episode,
)

__all__ = [
    "FLEET_MODES",
    "MODES",
    "Agent",
    "Diagnosis",
    "DriveSummary",
    "Episode",
    "EpisodeRecorder",
    "FleetAgent",
    "FleetEpisode",
    "FleetRecorder",
    "diagnose",
    "drive_summary",
    "record_episode",
    "record_fleet_episode",
    "replay_episode",
    "replay_fleet_episode",
]
