"""A grid warehouse for rational agents, with interchangeable motion backends."""

import warehouse_core.registration  # registers the environments with Gymnasium
import warehouse_core.viz.notebooks  # noqa: F401 - defines how notebooks show things
from warehouse_core.batch import BatchEnv
from warehouse_core.batch.fleet_settings import Battery, People
from warehouse_core.errors import BackendError, LayoutError, OrderError, RecordError, WarehouseError
from warehouse_core.fleet.env import FleetEnv
from warehouse_core.motion.base import Contact, Motion, Outcome
from warehouse_core.motion.grid import GridMotion
from warehouse_core.neighbours import warn_of_other_agents
from warehouse_core.orders.order import Order, OrderQueue, OrderStream
from warehouse_core.records.episode import Episode, FleetEpisode
from warehouse_core.records.recorder import (
    Agent,
    EpisodeRecorder,
    record_episode,
    record_fleet_episode,
    replay_episode,
    replay_fleet_episode,
)
from warehouse_core.task.settings import Settings
from warehouse_core.task.state import Observation, WarehouseState
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.warehouse_viz import replay_animation, save_frames_to_svg
from warehouse_core.world.generators import random_layout, shelf_layout
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.tiles import Cell

__all__ = [
    "DEFAULT_LAYOUT",
    "Agent",
    "BackendError",
    "BatchEnv",
    "Battery",
    "Cell",
    "Contact",
    "Episode",
    "EpisodeRecorder",
    "FleetEnv",
    "FleetEpisode",
    "GridMotion",
    "Layout",
    "LayoutError",
    "Motion",
    "Observation",
    "Order",
    "OrderError",
    "OrderQueue",
    "OrderStream",
    "Outcome",
    "People",
    "RecordError",
    "Settings",
    "WarehouseEnv",
    "WarehouseError",
    "WarehouseState",
    "random_layout",
    "record_episode",
    "record_fleet_episode",
    "replay_animation",
    "replay_episode",
    "replay_fleet_episode",
    "save_frames_to_svg",
    "shelf_layout",
]

warn_of_other_agents()
