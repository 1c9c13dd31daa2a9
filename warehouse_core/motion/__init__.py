"""Motions carry out the moves of robots: the interface, the grid backend, and backends by name."""

from warehouse_core.motion.backends import backend_names, load_backend, make_motion
from warehouse_core.motion.base import Conditions, Contact, HasConditions, Motion, Outcome
from warehouse_core.motion.batch import Batchable, BatchMotion, BatchOutcome

__all__ = [
    "BatchMotion",
    "BatchOutcome",
    "Batchable",
    "Conditions",
    "Contact",
    "HasConditions",
    "Motion",
    "Outcome",
    "backend_names",
    "load_backend",
    "make_motion",
]
