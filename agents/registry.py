"""Agents by name: a built-in agent, a trained one from its file, or a class of the user."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from agents.errors import AgentError
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_table import load_agent
from agents.search.agents import ALGORITHMS, ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout, RecordError

AGENTS: dict[str, Callable[..., Agent]] = {
    "greedy": GreedyAgent,
    "exploring": ExploringAgent,
    **{name: partial(SearchAgent, algorithm=name) for name in ALGORITHMS},
}

TRAINED: dict[str, Callable[..., Agent]] = {"ppo": PPOAgent.load, "q": load_agent}
"""Functions that load an agent of ``warehouse train``, by the word before the colon."""


def make_agent(name: str, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT) -> Agent:
    """Return an agent by name.

    Args:
        name: one of ``AGENTS``; one of ``TRAINED``, a colon and a file; or ``file.py:Class`` or
            ``package.module:Class``.
        seed: passed to the agent if it takes a ``seed``.
        layout: passed to the agent if it takes a ``layout``.

    Raises:
        AgentError: there is no such agent; the message says why.
    """
    word, colon, file = name.partition(":")
    if colon and word in TRAINED:
        return _load_trained(word, file, seed, layout)
    kind = AGENTS.get(name) or _load_class(name)
    try:
        return kind(**_wanted(kind, seed, layout))
    except TypeError as error:
        raise AgentError(f"agent {name!r} cannot be made without arguments: {error}") from error


def is_own_code(name: str) -> bool:
    """Return whether a name is that of a user's class, whose code ``make_agent`` would run."""
    return name not in AGENTS and name.partition(":")[0] not in TRAINED


def agent_file(name: str) -> Path | None:
    """Return the file that an agent is read from, or ``None`` if its name has no file."""
    word, colon, rest = name.partition(":")
    if colon and word in TRAINED:
        return Path(rest)
    source = name.rpartition(":")[0]
    return Path(source) if source.endswith(".py") else None


def _wanted(make: Callable[..., Agent], seed: int | None, layout: Layout) -> dict[str, Any]:
    """Return those of the two arguments that ``make`` takes, by name."""
    given = {"seed": seed, "layout": layout}
    return {name: given[name] for name in given.keys() & inspect.signature(make).parameters.keys()}


def _load_trained(word: str, file: str, seed: int | None, layout: Layout) -> Agent:
    load = TRAINED[word]
    if not file:
        raise AgentError(f"agent '{word}:' names no file; allowed: {word}:FILE")
    try:
        return load(Path(file), **_wanted(load, seed, layout))
    except OSError as error:
        raise AgentError(f"agent file {file}: {error.strerror or error}") from error
    except RecordError as error:
        raise AgentError(
            f"{error}; agent {word} needs what 'warehouse train {word}' saves"
        ) from error


def _load_class(name: str) -> type[Agent]:
    source, colon, class_name = name.rpartition(":")
    if not colon:
        allowed = [*AGENTS, *(f"{word}:FILE" for word in TRAINED)]
        raise AgentError(
            f"no agent is called {name!r}; allowed: {', '.join(allowed)}, "
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
    # The name must differ from those of modules that can be imported.
    spec = importlib.util.spec_from_file_location(f"agent file {path.stem}", path)
    assert spec is not None, "a .py file always has a spec"
    assert spec.loader is not None, "a .py file always has a loader"
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look it up there
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise AgentError(f"{source}, line {error.lineno}: {error.msg}") from error
    except ImportError as error:
        raise AgentError(f"cannot import agent file {source}: {error}") from error
    return module
