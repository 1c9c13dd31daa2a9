"""Registration of the environments with Gymnasium, so that ``gymnasium.make`` finds them.

Since version 1.0 Gymnasium does not read entry points. This package does not import Gymnasium,
because that takes longer than all its other imports together. It registers the names at once if
Gymnasium has been imported already, and otherwise whenever Gymnasium's code is executed. A look-up
such as ``importlib.util.find_spec("gymnasium")`` executes nothing, so it registers nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

ID = "Warehouse-v0"
"""Name under which ``gymnasium.make`` finds the environment."""

GOAL_ID = "WarehouseGoal-v0"
"""Name of the environment with goals."""

DRIVE_ID, DRIVE_PLACE = "WarehouseDrive-v0", "warehouse_physics.drive"
"""Name of the environment with continuous control, and the package that has it."""

GYMNASIUM, PLACE = "gymnasium", "warehouse_core.gymnasium_env"

ENTRY_POINTS = {
    ID: {
        "entry_point": f"{PLACE}:WarehouseGymnasiumEnv",
        "vector_entry_point": f"{PLACE}:WarehouseVectorEnv",
    },
    GOAL_ID: {"entry_point": f"{PLACE}:WarehouseGoalEnv"},
    DRIVE_ID: {
        "entry_point": f"{DRIVE_PLACE}:DriveEnv",
        "vector_entry_point": f"{DRIVE_PLACE}:DriveVectorEnv",
    },
}


def register(gymnasium: ModuleType) -> None:
    """Register the names that Gymnasium does not know yet.

    An environment is imported when it is first made. A module that is called ``gymnasium`` but has
    no registry, such as one that is still being imported, is left alone.
    """
    known = getattr(gymnasium, "registry", None)
    for name, places in ENTRY_POINTS.items():
        if known is not None and name not in known:
            gymnasium.register(name, **places)


class Registering(Loader):
    """A loader of Gymnasium that registers the names after it has executed the module."""

    def __init__(self, loader: Any) -> None:
        self._loader = loader

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Create the module as its own loader does."""
        created: ModuleType | None = self._loader.create_module(spec)
        return created

    def exec_module(self, module: ModuleType) -> None:
        """Execute the module and register the names; the module keeps its own loader."""
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._loader.exec_module(module)
        register(module)


class AfterGymnasium:
    """A finder of modules that lets the loader of Gymnasium register the names."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of Gymnasium that the other finders find, with another loader."""
        if name != GYMNASIUM:
            return None
        for finder in sys.meta_path:
            if type(finder).__name__ != type(self).__name__:
                spec = finder.find_spec(name, path, target)
                if spec is not None and spec.loader is not None:
                    spec.loader = Registering(spec.loader)
                if spec is not None:
                    return spec
        return None


def watch() -> None:
    """Register the names now if possible, and whenever Gymnasium is executed from now on."""
    if GYMNASIUM in sys.modules:
        register(sys.modules[GYMNASIUM])
    # After a reload of this module, the finder of its former code makes room for the new one.
    former = [each for each in sys.meta_path if type(each).__name__ == AfterGymnasium.__name__]
    for finder in former:
        sys.meta_path.remove(finder)
    sys.meta_path.insert(0, AfterGymnasium())


watch()
