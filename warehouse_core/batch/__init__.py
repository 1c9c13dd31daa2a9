"""Many warehouses at once, in NumPy arrays.

Example:
    >>> from warehouse_core.batch import AUTORESET_MODES
    >>> AUTORESET_MODES
    ('NextStep', 'SameStep', 'Disabled')
"""

from warehouse_core.batch.lone.env import BatchEnv
from warehouse_core.batch.shell.env import AUTORESET_MODES

__all__ = ["AUTORESET_MODES", "BatchEnv"]
