"""Run a command-line application; errors become exit codes."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import typer
from typer.exceptions import TyperException

from agents.lab.console.terminal import print_error, say
from warehouse_core.errors import WarehouseError

USER_ERROR, INTERRUPTED = 1, 130

EXPECTED = (WarehouseError, OSError)
"""Errors that a user may cause. Any other error is a bug and keeps its traceback."""


def application(**settings: Any) -> typer.Typer:
    """Return an application whose help is plain text, since Rich takes long to import."""
    return typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
        **settings,
    )


def main(app: typer.Typer, arguments: Sequence[str] | None = None) -> None:
    """Run a command line and exit: 0 done, 1 error, 2 wrong usage, 130 interrupted."""
    try:
        command = typer.main.get_command(app)
        code = command.main(arguments, standalone_mode=False)
        if code == INTERRUPTED:  # an interrupt, which Typer has caught
            _fail("interrupted", INTERRUPTED)
    except TyperException as error:
        message, code = error.format_message(), error.exit_code
        if message.startswith("Usage:"):  # the whole help, where a command is missing
            say(message, error=True)
        else:
            _fail(message, code)
    except EXPECTED as error:
        code = _fail(_describe(error), USER_ERROR)
    except (typer.Abort, KeyboardInterrupt) as error:
        code = _fail(f"interrupted {error.__cause__ or ''}", INTERRUPTED)
    sys.exit(code)


def _fail(message: str, code: int) -> int:
    print_error(message)
    return code


def _describe(error: Exception) -> str:
    if isinstance(error, BrokenPipeError):
        # The reader of standard output is gone; prevent another error when Python flushes it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
