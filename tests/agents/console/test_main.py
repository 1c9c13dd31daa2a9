import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from helpers.command_line import Result, command

from agents.console.main import LONGEST
from agents.console.options import BatteryOption, load_layout
from agents.errors import (
    AgentError,
    ClusterError,
    EpisodeError,
    ParameterError,
    StoreError,
    WorkerError,
)
from warehouse_core import DEFAULT_LAYOUT, BackendError, LayoutError, RecordError
from warehouse_core.errors import FormatError, NoDisplayError


def outcome_of(capsys: pytest.CaptureFixture[str], error: BaseException | None) -> Result:
    """Return what a command that raises ``error`` comes to."""
    app = typer.Typer(add_completion=False)

    @app.command()
    def fail() -> None:
        print("working")
        if error is not None:
            raise error

    return command(capsys, app=app)


def test_a_command_that_succeeds_ends_with_0(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome_of(capsys, None) == (0, "working\n", "")


@pytest.mark.parametrize(
    "kind",
    [
        AgentError,
        BackendError,
        ClusterError,
        EpisodeError,
        FormatError,
        LayoutError,
        NoDisplayError,
        RecordError,
        ParameterError,
        StoreError,
        WorkerError,
    ],
)
def test_a_users_error_is_one_line_and_ends_with_1(
    capsys: pytest.CaptureFixture[str], kind: type[Exception]
) -> None:
    assert outcome_of(capsys, kind("not\nlike\n   this")) == (
        1,
        "working\n",
        "warehouse: not like this\n",
    )


def test_a_file_error_names_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    error = PermissionError(errno.EACCES, "Permission denied", "here.txt")
    assert outcome_of(capsys, error).err == "warehouse: here.txt: Permission denied\n"


def test_a_file_error_without_a_file_says_what_there_is(
    capsys: pytest.CaptureFixture[str],
) -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    assert outcome_of(capsys, full).err == "warehouse: No space left on device\n"
    assert outcome_of(capsys, OSError("all is lost")).err == "warehouse: all is lost\n"


def test_what_a_terminal_would_obey_or_cannot_show_is_written_out(
    capsys: pytest.CaptureFixture[str],
) -> None:
    error = LayoutError("\x1b[2Jclean\a \udcff \u202e Müller")
    line = r"warehouse: \x1b[2Jclean\x07 \udcff \u202e Müller"
    assert outcome_of(capsys, error).err == f"{line}\n"


def test_a_value_as_long_as_a_file_does_not_fill_the_screen(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = outcome_of(capsys, LayoutError(10**6 * "x")).err
    assert line == f"warehouse: {LONGEST * 'x'}...\n"


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, typer.Abort])
def test_an_interrupt_ends_with_130(
    capsys: pytest.CaptureFixture[str], interrupt: type[BaseException]
) -> None:
    result = outcome_of(capsys, interrupt())
    assert result.code == 130
    assert result.err.strip() in ("", "warehouse: interrupted")


def test_a_command_may_end_with_a_code_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome_of(capsys, typer.Exit(3)).code == 3
    assert outcome_of(capsys, typer.Exit()).code == 0


@pytest.mark.parametrize("kind", [ZeroDivisionError, ValueError, TypeError, AssertionError])
def test_a_fault_of_the_program_keeps_its_traceback(
    capsys: pytest.CaptureFixture[str], kind: type[Exception]
) -> None:
    with pytest.raises(kind):
        outcome_of(capsys, kind("a bug"))


def test_wrong_usage_ends_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    app = typer.Typer(add_completion=False)

    @app.command()
    def charge(battery: BatteryOption = 5) -> None:
        print(battery)

    assert command(capsys, "--battery", "7", app=app) == (0, "7\n", "")
    for words in (["--battery", "0"], ["--battery", "x"], ["--battery"], ["--fast"], ["more"]):
        result = command(capsys, *words, app=app)
        assert result.code == 2, words
        assert result.out == ""
        assert result.err.startswith("warehouse: ")
        assert result.err.count("\n") == 1


def test_a_layout_is_the_chapters_unless_there_is_a_file(tmp_path: Path) -> None:
    assert load_layout(None) is DEFAULT_LAYOUT
    (tmp_path / "room.txt").write_text("P.D\n")
    assert load_layout(tmp_path / "room.txt").rows == ("P.D",)


def test_a_reader_that_goes_away_leaves_no_traceback(tmp_path: Path) -> None:
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
