import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from helpers.command_line import Result, Warehouse

from agents.errors import AgentError
from agents.lab.console.terminal import MAX_LENGTH
from warehouse_core import LayoutError


def outcome_of(warehouse: Warehouse, error: BaseException | None) -> Result:
    """Return the result of a command that raises ``error``."""
    app = typer.Typer(add_completion=False)

    @app.command()
    def fail() -> None:
        print("working")
        if error is not None:
            raise error

    return warehouse(app=app)


ESCAPED = r"\x1b[2Jclean\x07 \udcff \u202e Müller"


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (None, 0, ""),
        (typer.Exit(), 0, ""),
        (typer.Exit(3), 3, ""),
        (AgentError("not\nlike\n   this"), 1, "not like this"),
        (LayoutError("not\nlike\n   this"), 1, "not like this"),
        (LayoutError("\x1b[2Jclean\a \udcff \u202e Müller"), 1, ESCAPED),
        (LayoutError(10**6 * "x"), 1, f"{MAX_LENGTH * 'x'}..."),
        (PermissionError(errno.EACCES, "Denied", "here.txt"), 1, "here.txt: Denied"),
        (OSError(errno.ENOSPC, "No space left on device"), 1, "No space left on device"),
        (OSError("something else"), 1, "something else"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (typer.Abort(), 130, "interrupted"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
def test_an_error_that_a_user_may_cause_is_a_code_and_one_line(
    warehouse: Warehouse, error: BaseException | None, code: int, message: str
) -> None:
    line = f"warehouse: {message}\n" if message else ""
    assert outcome_of(warehouse, error) == (code, "working\n", line)


@pytest.mark.parametrize("kind", [ValueError, RuntimeError])
def test_any_other_error_keeps_its_traceback(warehouse: Warehouse, kind: type[Exception]) -> None:
    with pytest.raises(kind):
        outcome_of(warehouse, kind("a bug"))


def test_a_closed_pipe_leaves_no_traceback(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "agents.run_episode", "--seed", "1", "--no-show"],
            cwd=tmp_path,
            stdout=writing,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    finally:
        os.close(writing)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
