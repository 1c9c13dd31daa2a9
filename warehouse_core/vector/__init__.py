"""Many warehouses at once, in NumPy arrays."""

from warehouse_core.vector.env import AUTORESET_MODES, BatchEnv

__all__ = ["AUTORESET_MODES", "BatchEnv"]
