"""Run an agent in this process, where there can be no other, as in a browser.

Nothing keeps such an agent from anything, and it is not interrupted when it takes too long: whoever
grades it so has to trust it, and to end the process.
"""

from __future__ import annotations

import builtins
import importlib
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from agents.lab.grading import child
from agents.lab.grading.sandbox import AgentLimits, AgentProcess, failure_of


class AgentHere(AgentProcess):
    """An agent in this process; it is asked as one in another, and answers at once."""

    def __init__(self, limits: AgentLimits) -> None:
        super().__init__(-1, -1, limits)
        self._reply: Any = None
        self._file: str | None = None

    def _ask(self, question: dict[str, Any], seconds: float) -> dict[str, Any]:
        asked = json.loads(json.dumps(question))
        try:
            if self._reply is None:
                self._file = asked["file"]
                if asked["allowed"] is not None or asked["denied"]:
                    child.guard_imports(asked)
                name, self._reply = child.begin(asked)
                return {"name": name}
            answer: dict[str, Any] = self._reply(asked)
        except (Exception, SystemExit) as error:
            raise failure_of(child.described(error, self._file)) from error
        return answer


class SameProcess:
    """Stands for a ``Sandbox`` where agents run in this process; limits of memory are not kept."""

    def __init__(self, limits: AgentLimits) -> None:
        self._limits = limits

    def __enter__(self) -> SameProcess:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    @contextmanager
    def episode(self) -> Iterator[AgentHere]:
        """Yield an agent that is not loaded yet; what it may import is forgotten after."""
        paths, by_statement, by_name = sys.path[:], builtins.__import__, importlib.import_module
        try:
            yield AgentHere(self._limits)
        finally:
            sys.path[:] = paths
            builtins.__import__, importlib.import_module = by_statement, by_name
