"""Forms of a fleet's step: NumPy arrays, or loops that Numba compiles if it is installed."""

import pytest

MODULES = ("motion.grid", "batch.fleets")
"""Modules of the core that have loops."""


def use_loops(monkeypatch: pytest.MonkeyPatch, loops: bool) -> None:
    """Let fleets use their loops, which are plain Python without Numba, or NumPy."""
    for module in MODULES:
        monkeypatch.setattr(f"warehouse_core.{module}.IS_COMPILED", loops)
