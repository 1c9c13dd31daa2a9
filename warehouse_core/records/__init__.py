"""Records of episodes, their files, and failure modes."""

from warehouse_core.records.episode import (
    Agent,
    Episode,
    EpisodeRecorder,
    record_episode,
    replay_episode,
)
from warehouse_core.records.failure_modes import MODES, Diagnosis, diagnose

__all__ = [
    "MODES",
    "Agent",
    "Diagnosis",
    "Episode",
    "EpisodeRecorder",
    "diagnose",
    "record_episode",
    "replay_episode",
]
