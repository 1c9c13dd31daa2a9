"""Many warehouses at once, in NumPy arrays.

Example:
    >>> from warehouse_core.batch import AUTORESET_MODES
    >>> AUTORESET_MODES
    ('NextStep', 'SameStep', 'Disabled')
"""

from warehouse_core.batch.array_env import AUTORESET_MODES
from warehouse_core.batch.lone import BatchEnv

__all__ = ["AUTORESET_MODES", "BatchEnv"]
