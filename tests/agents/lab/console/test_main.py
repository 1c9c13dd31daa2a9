import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from helpers.command_line import Result, command

from agents.errors import AgentError
from agents.lab.console.terminal import MAX_LENGTH
from warehouse_core import LayoutError


def outcome_of(capsys: pytest.CaptureFixture[str], error: BaseException | None) -> Result:
    """Return the result of a command that raises ``error``."""
    app = typer.Typer(add_completion=False)

    @app.command()
    def fail() -> None:
        print("working")
        if error is not None:
            raise error

    return command(capsys, app=app)


def test_a_command_that_succeeds_ends_with_0(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome_of(capsys, None) == (0, "working\n", "")


@pytest.mark.parametrize("kind", [AgentError, LayoutError])
def test_an_expected_error_is_one_line_and_ends_with_1(
    capsys: pytest.CaptureFixture[str], kind: type[Exception]
) -> None:
    message = "warehouse: not like this\n"
    assert outcome_of(capsys, kind("not\nlike\n   this")) == (1, "working\n", message)


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (
            PermissionError(errno.EACCES, "Permission denied", "here.txt"),
            "here.txt: Permission denied",
        ),
        (OSError(errno.ENOSPC, "No space left on device"), "No space left on device"),
        (OSError("something else"), "something else"),
    ],
)
def test_a_file_error_names_the_file_if_there_is_one(
    capsys: pytest.CaptureFixture[str], error: OSError, message: str
) -> None:
    assert outcome_of(capsys, error).err == f"warehouse: {message}\n"


def test_unprintable_characters_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    error = LayoutError("\x1b[2Jclean\a \udcff \u202e Müller")
    line = r"warehouse: \x1b[2Jclean\x07 \udcff \u202e Müller"
    assert outcome_of(capsys, error).err == f"{line}\n"


def test_a_long_message_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    line = outcome_of(capsys, LayoutError(10**6 * "x")).err
    assert line == f"warehouse: {MAX_LENGTH * 'x'}...\n"


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, typer.Abort])
def test_an_interrupt_ends_with_130(
    capsys: pytest.CaptureFixture[str], interrupt: type[BaseException]
) -> None:
    result = outcome_of(capsys, interrupt())
    assert (result.code, result.err) == (130, "warehouse: interrupted\n")


def test_a_command_may_end_with_its_own_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome_of(capsys, typer.Exit(3)).code == 3
    assert outcome_of(capsys, typer.Exit()).code == 0


@pytest.mark.parametrize("kind", [ValueError, RuntimeError])
def test_any_other_error_keeps_its_traceback(
    capsys: pytest.CaptureFixture[str], kind: type[Exception]
) -> None:
    with pytest.raises(kind):
        outcome_of(capsys, kind("a bug"))


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
