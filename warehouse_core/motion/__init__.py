"""Motions carry out the moves of robots: the interface, the grid backend, and backends by name."""

from warehouse_core.motion.backends import backend_names, load_backend, make_motion
from warehouse_core.motion.base import (
    BaseBatchMotion,
    BaseMotion,
    BatchMotion,
    BatchOutcome,
    Conditions,
    Contact,
    Motion,
    Outcome,
)

__all__ = [
    "BaseBatchMotion",
    "BaseMotion",
    "BatchMotion",
    "BatchOutcome",
    "Conditions",
    "Contact",
    "Motion",
    "Outcome",
    "backend_names",
    "load_backend",
    "make_motion",
]
