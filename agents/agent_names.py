"""Agents by name, for the command line: a built-in name, or somebody's own class."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Agent

AGENTS: dict[str, type[Agent]] = {"greedy": GreedyAgent}


class AgentError(ValueError):
    """No agent of that name, or a file or class that is none."""


def make_agent(name: str, seed: int | None = None) -> Agent:
    """Return an agent by name.

    Args:
        name: one of ``AGENTS``, or ``file.py:Class`` or ``package.module:Class``.
        seed: given to the agent if its class takes a ``seed``.

    Raises:
        AgentError: saying what is wrong with the name.
    """
    kind = AGENTS.get(name) or _load_class(name)
    takes_seed = "seed" in inspect.signature(kind).parameters
    options: dict[str, Any] = {"seed": seed} if takes_seed else {}
    try:
        return kind(**options)
    except TypeError as error:
        raise AgentError(f"agent {name!r} cannot be made without arguments: {error}") from error


def _load_class(name: str) -> type[Agent]:
    source, colon, class_name = name.rpartition(":")
    if not colon:
        raise AgentError(
            f"no agent is called {name!r}; allowed: {', '.join(AGENTS)}, "
            "or your own as file.py:Class or module:Class"
        )
    kind: Any = getattr(_load_module(source), class_name, None)
    if not isinstance(kind, type):
        raise AgentError(f"{source} has no class {class_name!r}")
    missing = [method for method in ("reset", "act") if not callable(getattr(kind, method, None))]
    if missing:
        raise AgentError(f"class {name!r} has no {' and no '.join(missing)}; an agent needs both")
    found: type[Agent] = kind
    return found


def _load_module(source: str) -> ModuleType:
    if not source.endswith(".py"):
        if not all(part.isidentifier() for part in source.split(".")):
            raise AgentError(f"{source!r} is neither a .py file nor the name of a module")
        try:
            return importlib.import_module(source)
        except ImportError as error:
            raise AgentError(f"cannot import agent module {source!r}: {error}") from error
    path = Path(source)
    if not path.is_file():
        raise AgentError(f"agent file {source} does not exist")
    # The name must not be that of a module which is imported under it.
    spec = importlib.util.spec_from_file_location(f"agent file {path.stem}", path)
    assert spec is not None, "a .py file always has a spec"
    assert spec.loader is not None, "a .py file always has a loader"
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise AgentError(f"{source}, line {error.lineno}: {error.msg}") from error
    except ImportError as error:
        raise AgentError(f"cannot import agent file {source}: {error}") from error
    return module
