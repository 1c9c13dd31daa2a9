"""Helpers for tests of the command line."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

from agents.lab.commands import cli
from agents.lab.console.main import main

ROOT = Path(__file__).resolve().parents[2]
DISPLAY_VARIABLES = ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND")


program = cache(typer.main.get_command)
"""Return the command of an application. It takes 30 ms to build ``warehouse``, so it is cached."""


def leaves(group: Any, *words: str) -> Iterator[tuple[str, Any]]:
    """Yield the words and the command of each command that the help lists and that runs."""
    for name, each in group.commands.items():
        if each.hidden:
            continue
        if hasattr(each, "commands"):
            yield from leaves(each, *words, name)
        else:
            yield " ".join((*words, name)), each


LEAVES = dict(leaves(program(cli.app)))
"""The commands of ``warehouse``."""


class Result(NamedTuple):
    """The result of a command."""

    code: int
    out: str
    err: str


Warehouse = Callable[..., Result]
Refused = Callable[..., str]
"""The fixtures ``warehouse`` and ``refused``: ``command`` and ``refusal`` without ``capsys``."""


def command(
    capsys: pytest.CaptureFixture[str], *words: object, app: typer.Typer = cli.app
) -> Result:
    """Run a command in this process."""
    capsys.readouterr()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", program)
        with pytest.raises(SystemExit) as ended:
            main(app, [str(word) for word in words])
    out, err = capsys.readouterr()
    assert isinstance(ended.value.code, int | None)
    return Result(ended.value.code or 0, out, err)


def refusal(
    capsys: pytest.CaptureFixture[str], *words: object, code: int = 1, app: typer.Typer = cli.app
) -> str:
    """Run a command that must fail with ``code`` and one line, and return the line."""
    result = command(capsys, *words, app=app)
    assert result.code == code
    line = result.err
    assert line.startswith("warehouse: ")
    assert line.endswith("\n")
    assert line.count("\n") == 1
    return line.removeprefix("warehouse: ").rstrip("\n")


def write_mine(method: str, line: str, returned: str, step: int = 4) -> None:
    """Write a file ``mine.py`` with a class ``Mine``, an agent or a planner by its method.

    In one of its steps it executes ``line``, which is line 9 of the file. It returns ``returned``.
    """
    Path("mine.py").write_text(f"""
class Mine:
    def reset(self):
        self.steps = 0

    def {method}(self, seen):
        self.steps += 1
        if self.steps == {step}:
            {line}
        return {returned}
""")


def in_a_process(*words: object, folder: Path, **variables: str) -> Result:
    """Run Python with ``words`` in its own process, without a display; SIGINT interrupts it."""
    environment = {
        name: value for name, value in os.environ.items() if name not in DISPLAY_VARIABLES
    }
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder,
        env=environment | variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=heed_interrupts,
    )
    return Result(done.returncode, done.stdout, done.stderr)


def in_the_background(program: str, *words: object) -> subprocess.Popen[str]:
    """Start a program with ``words`` in its own process here; SIGINT interrupts it."""
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    )


def heed_interrupts() -> None:
    """Make SIGINT interrupt again, because tests that run in the background ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def without_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prevent matplotlib from opening windows."""
    import matplotlib.pyplot as plt

    for name in DISPLAY_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    plt.switch_backend("agg")
