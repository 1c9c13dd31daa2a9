"""A grid warehouse for rational agents, with a motion backend that can be swapped."""

from warehouse_core.backends import BackendError
from warehouse_core.episode import (
    Agent,
    Episode,
    EpisodeRecorder,
    record_episode,
    replay_episode,
)
from warehouse_core.layout import DEFAULT_LAYOUT, Cell, Layout, LayoutError
from warehouse_core.layout_generator import random_layout, shelf_layout
from warehouse_core.motion import Contact, Motion, Outcome
from warehouse_core.safe_npz import RecordError
from warehouse_core.settings import Settings
from warehouse_core.warehouse_env import Observation, WarehouseEnv, WarehouseState

__all__ = [
    "DEFAULT_LAYOUT",
    "Agent",
    "BackendError",
    "Cell",
    "Contact",
    "Episode",
    "EpisodeRecorder",
    "Layout",
    "LayoutError",
    "Motion",
    "Observation",
    "Outcome",
    "RecordError",
    "Settings",
    "WarehouseEnv",
    "WarehouseState",
    "random_layout",
    "record_episode",
    "replay_episode",
    "shelf_layout",
]
