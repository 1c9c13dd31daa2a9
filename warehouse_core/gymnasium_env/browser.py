"""Importing this module lets Gymnasium be imported in a browser, where Python has no processes.

Gymnasium imports ``multiprocessing.synchronize`` for environments in processes of their own, and
that needs ``_multiprocessing``, which Pyodide leaves out.
"""

from __future__ import annotations

import sys
from types import ModuleType

NAME = "_multiprocessing"


def stand_in() -> ModuleType:
    """Return a module that can be imported as ``_multiprocessing``, but starts nothing."""
    module = ModuleType(NAME, "Stands for what Pyodide leaves out.")
    vars(module).update(SemLock=type("SemLock", (), {"SEM_VALUE_MAX": 1}), sem_unlink=None)
    return module


if sys.platform == "emscripten":
    sys.modules.setdefault(NAME, stand_in())
