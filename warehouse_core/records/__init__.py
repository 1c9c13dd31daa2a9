"""Records of episodes, their files, and failure modes."""

from warehouse_core.records.episode import (
    Agent,
    Episode,
    EpisodeRecorder,
    record_episode,
    replay_episode,
)
from warehouse_core.records.failure_modes import MODES, Diagnosis, diagnose
from warehouse_core.records.fleet_episode import (
    FleetAgent,
    FleetEpisode,
    FleetRecorder,
    record_fleet_episode,
    replay_fleet_episode,
)

__all__ = [
    "MODES",
    "Agent",
    "Diagnosis",
    "Episode",
    "EpisodeRecorder",
    "FleetAgent",
    "FleetEpisode",
    "FleetRecorder",
    "diagnose",
    "record_episode",
    "record_fleet_episode",
    "replay_episode",
    "replay_fleet_episode",
]
