"""The warehouse as Gymnasium environments: importing this package registers ``Warehouse-v0``.

``gymnasium.make("warehouse_core.gymnasium_env:Warehouse-v0", backend="physics")`` does so. The
rules are not here: this package adds spaces and infos to ``WarehouseEnv`` and ``BatchEnv``.

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

import warehouse_core.gymnasium_env.browser  # noqa: F401 - lets Gymnasium be imported there

# isort: split
import gymnasium

from warehouse_core.gymnasium_env.env import WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env.spaces import FORMS, Extent, Form, make_form
from warehouse_core.gymnasium_env.vector import WarehouseVectorEnv

ID = "Warehouse-v0"
"""Name under which ``gymnasium.make`` finds the environment."""

gymnasium.register(
    ID,
    entry_point=f"{__name__}:{WarehouseGymnasiumEnv.__name__}",
    vector_entry_point=f"{__name__}:{WarehouseVectorEnv.__name__}",
)

__all__ = [
    "FORMS",
    "ID",
    "Extent",
    "Form",
    "WarehouseGymnasiumEnv",
    "WarehouseVectorEnv",
    "make_form",
]
