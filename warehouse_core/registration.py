"""Registration of the environments with Gymnasium, so that ``gymnasium.make`` finds them.

Since version 1.0 Gymnasium does not read entry points. This package does not import Gymnasium,
because that takes longer than all its other imports together. It registers the names at once if
Gymnasium has been imported already, and otherwise right after Gymnasium is imported.
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
"""Name of the environment with goals."""

GYMNASIUM, PLACE = "gymnasium", "warehouse_core.gymnasium_env"


def register(gymnasium: ModuleType) -> None:
    """Register the names with Gymnasium; an environment is imported when it is first made."""
    gymnasium.register(
        ID,
        entry_point=f"{PLACE}:WarehouseGymnasiumEnv",
        vector_entry_point=f"{PLACE}:WarehouseVectorEnv",
    )
    gymnasium.register(GOAL_ID, entry_point=f"{PLACE}:WarehouseGoalEnv")


class AfterGymnasium:
    """A finder of modules that registers the names once Gymnasium has been imported."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the ordinary spec of Gymnasium, whose loader registers the names at the end."""
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
