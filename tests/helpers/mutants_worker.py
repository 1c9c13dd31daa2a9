"""Runs chosen tests of the copy of the project in the current folder, for ``bench_mutants.py``.

Tests are collected once. Each request is run in a forked process, in which functions get the code
of their files as they are now. Arguments: file descriptors of requests and answers, then pytest's.
"""

import gc
import json
import os
import sys
from pathlib import Path
from types import CodeType, FunctionType

import pytest

NOT_APPLIED = 77
"""Exit code if a file was changed outside of its functions after it had been imported."""


def codes_in(code: CodeType) -> dict[tuple[str, int], CodeType]:
    """Return the code of all functions and classes in a code object, by name and first line."""
    found = {}
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            found |= {(inner.co_qualname, inner.co_firstlineno): inner} | codes_in(inner)
    return found


def apply(path: str) -> bool:
    """Give functions of a module the code of its file; return whether that was enough."""
    name = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    if name not in sys.modules:
        return True
    file = str(Path(path).absolute())
    codes = codes_in(compile(Path(file).read_bytes(), file, "exec"))
    is_applied = False
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename == file:
            old = each.__code__
            new = codes.get((old.co_qualname, old.co_firstlineno), old)
            if new != old:
                try:
                    each.__code__ = new
                except ValueError:  # it has other variables of enclosing functions
                    return False
                is_applied = True
    return is_applied


class Worker:
    """Plugin of pytest that runs tests on request."""

    def __init__(self, requests: int, answers: int) -> None:
        self.requests = os.fdopen(requests)
        self.answers = os.fdopen(answers, "w")

    def say(self, text: str) -> None:
        print(text, file=self.answers, flush=True)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        items = {item.nodeid: item for item in session.items}
        for request in self.requests:
            path, tests, folders = json.loads(request)
            child = os.fork()
            if child:
                _, status = os.waitpid(child, 0)
                self.say(f"code {os.waitstatus_to_exitcode(status)}")
                continue
            if path and not apply(path):
                os._exit(NOT_APPLIED)
            names = [*tests, *(name for name in items if name.startswith(tuple(folders)))]
            session.items[:] = [items[name] for name in dict.fromkeys(names) if name in items]
            return  # pytest runs these
        os._exit(0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.say(f"failed {report.nodeid}")


if __name__ == "__main__":
    requests, answers, *arguments = sys.argv[1:]
    sys.exit(pytest.main(arguments, plugins=[Worker(int(requests), int(answers))]))
