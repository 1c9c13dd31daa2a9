"""The task of a robot: rules, starts, observations and settings."""

from warehouse_core.task.encoding import encode, vector
from warehouse_core.task.rules import judge, useful_actions
from warehouse_core.task.settings import Settings
from warehouse_core.task.state import Observation, WarehouseState

__all__ = [
    "Observation",
    "Settings",
    "WarehouseState",
    "encode",
    "judge",
    "useful_actions",
    "vector",
]
