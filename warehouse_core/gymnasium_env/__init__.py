"""The warehouse as Gymnasium environments, ``Warehouse-v0`` and ``WarehouseGoal-v0``.

Importing ``warehouse_core`` registers them. Calling
``gymnasium.make("warehouse_core.gymnasium_env:Warehouse-v0", backend="physics")`` does so too. This
package has no rules. It adds spaces and infos to ``WarehouseEnv`` and ``BatchEnv``.

Example:
    >>> import gymnasium
    >>> from warehouse_core.gymnasium_env import FORMS, ID
    >>> FORMS
    ('dict', 'vector', 'image')
    >>> env = gymnasium.make(ID, observation="vector")
    >>> observation, info = env.reset(seed=1)
    >>> observation.shape
    (86,)
"""

import gymnasium

from warehouse_core.gymnasium_env.env import WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env.goals import WarehouseGoalEnv
from warehouse_core.gymnasium_env.spaces import FORMS, Extent, Form, make_form
from warehouse_core.gymnasium_env.vector import WarehouseVectorEnv
from warehouse_core.registration import GOAL_ID, ID, register

__all__ = [
    "FORMS",
    "GOAL_ID",
    "ID",
    "Extent",
    "Form",
    "WarehouseGoalEnv",
    "WarehouseGymnasiumEnv",
    "WarehouseVectorEnv",
    "make_form",
]

register(gymnasium)
