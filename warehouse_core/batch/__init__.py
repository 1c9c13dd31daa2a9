"""Many warehouses at once, in NumPy arrays."""

from warehouse_core.batch.lone.env import BatchEnv
from warehouse_core.batch.shell.env import AUTORESET_MODES

__all__ = ["AUTORESET_MODES", "BatchEnv"]
