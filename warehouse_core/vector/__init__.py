"""Many warehouses at once, in NumPy arrays."""

from warehouse_core.vector.env import BatchEnv
from warehouse_core.vector.rows import AUTORESET_MODES

__all__ = ["AUTORESET_MODES", "BatchEnv"]
