"""Names of environments by which ``gymnasium.make`` finds them.

Gymnasium reads no entry points since 1.0, and this package does not import it, which takes longer
than all else. So the names are registered when Gymnasium is there, now or later.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType

ID = "Warehouse-v0"
"""Name under which ``gymnasium.make`` finds the environment."""

GOAL_ID = "WarehouseGoal-v0"
"""Name of its form with goals."""

GYMNASIUM, PLACE = "gymnasium", "warehouse_core.gymnasium_env"


def register(gymnasium: ModuleType) -> None:
    """Tell Gymnasium the names; no environment is imported before it is made."""
    gymnasium.register(
        ID,
        entry_point=f"{PLACE}:WarehouseGymnasiumEnv",
        vector_entry_point=f"{PLACE}:WarehouseVectorEnv",
    )
    gymnasium.register(GOAL_ID, entry_point=f"{PLACE}:WarehouseGoalEnv")


class AfterGymnasium:
    """A finder of modules that registers the names when Gymnasium has been imported."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find Gymnasium as all others do, and let its import end with the registration."""
        if name != GYMNASIUM:
            return None
        sys.meta_path.remove(self)
        spec = find_spec(name)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def exec_module(module: ModuleType) -> None:
                execute(module)
                register(module)

            spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


if GYMNASIUM in sys.modules:
    register(sys.modules[GYMNASIUM])
else:
    sys.meta_path.insert(0, AfterGymnasium())
