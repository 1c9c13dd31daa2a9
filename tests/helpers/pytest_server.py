"""Runs pytest again and again in a folder, each time in a process with the libraries loaded.

``python pytest_server.py FOLDER``: each line of the input is a JSON list of arguments. The answer
is a JSON list: the exit code, negative for the signal that ended it, and the lines that it wrote.
"""

import importlib
import json
import os
import signal
import sys
import tempfile
from pathlib import Path

SECONDS = 3600
"""After which a run is ended by a signal."""

LIBRARIES = (
    "hypothesis", "matplotlib.backends.backend_agg", "matplotlib.pyplot", "numpy", "pymunk",
    "pytest", "scipy.stats", "typer.testing",
)  # fmt: skip


def run(arguments: list[str]) -> tuple[int, list[str]]:
    """Return the exit code of pytest and what it has written."""
    with tempfile.TemporaryFile("w+") as output:
        child = os.fork()
        if child == 0:
            signal.alarm(SECONDS)
            for number in (1, 2):
                os.dup2(output.fileno(), number)
            os._exit(run_here(arguments))
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        output.seek(0)
        return code, output.read().splitlines()


def run_here(arguments: list[str]) -> int:
    import pytest

    code = int(pytest.main(["-W", "ignore::pytest.PytestAssertRewriteWarning", *arguments]))
    sys.stdout.flush()
    return code


if __name__ == "__main__":  # the workers of a sweep import this file
    folder = Path(sys.argv[1])
    os.chdir(folder)
    sys.path[0] = str(folder)
    os.environ["PYTHONPATH"] = str(folder)
    for name in LIBRARIES:
        importlib.import_module(name)
    for line in sys.stdin:
        print(json.dumps(run(json.loads(line))), flush=True)
