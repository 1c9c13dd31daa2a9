"""A warning if another project's package ``agents`` hides the one of this project."""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from typing import Any

OWN = "agents.warehouse_agent_greedy"
"""Text in the source of this project's package ``agents``."""


def warn_of_other_agents() -> None:
    """Warn if ``import agents`` would import, or has imported, another project's module."""
    try:
        spec = find_spec("agents")
        loader: Any = spec and spec.loader
        source = loader.get_source("agents") if loader else OWN
    except (AttributeError, ImportError, ValueError):  # a module made by hand, or without source
        spec, source = None, ""
    if OWN not in (source or ""):
        place = spec.origin if spec else "in memory"
        warnings.warn(
            f"the module agents ({place}) is not the one of warehouse-lab: 'from agents import "
            "GreedyAgent' fails; install warehouse-lab in a virtual environment of its own, or "
            "rename your file agents.py",
            stacklevel=3,
        )
