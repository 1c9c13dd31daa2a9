"""Run a command-line application, and turn errors into messages and exit codes."""

from __future__ import annotations

import ast
import inspect
import os
import re
import sys
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import typer
from typer.exceptions import TyperException

from agents.lab.console.group import HELP, CommandGroup
from agents.lab.console.terminal import print_error, say
from warehouse_core.errors import WarehouseError

USER_ERROR, INTERRUPTED = 1, 130

EXPECTED = (WarehouseError, OSError)
"""Errors that a user may cause. Any other error is a bug and keeps its traceback."""

SENTENCES = (
    (r"No such option: (\S+)", r"no option is called '\1'"),
    (r"No such option: (\S+) \(.*: (.+)\)", r"no option is called '\1'; similar: \2"),
    (r"Option '(\S+)' requires an argument\.", r"\1 needs a value after it"),
    (r"Option '(\S+)' does not take a value\.", r"\1 takes no value"),
    (r"Missing argument '(.+)'\.", r"\1 is missing"),
    (r"Got unexpected extra argument\S* \((.+)\)", r"'\1' is an unexpected argument"),
)
"""Patterns of Typer's messages about wrong usage, and the sentences printed in their place."""


def application(**settings: Any) -> typer.Typer:
    """Return an application whose help is plain text, because Rich takes long to import."""
    return typer.Typer(
        cls=settings.pop("cls", CommandGroup),
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": [*HELP]},
        **settings,
    )


def help_of(command: Callable[..., Any]) -> str:
    """Return the help of a command: its docstring, which ``python -OO`` leaves in the source."""
    if command.__doc__:
        return command.__doc__
    source = ast.parse(textwrap.dedent(inspect.getsource(command))).body[0]
    return ast.get_docstring(source) or ""  # type: ignore[arg-type]


def main(app: typer.Typer, arguments: Sequence[str] | None = None) -> None:
    """Run a command line and exit.

    The exit code is 0 after success, 1 after an error, 2 after wrong usage, and 130 after an
    interrupt.
    """
    try:
        command = typer.main.get_command(app)
        code = command.main(arguments, standalone_mode=False)
        if code == INTERRUPTED:  # Typer has caught an interrupt
            _fail("interrupted", INTERRUPTED)
    except TyperException as error:
        code = error.exit_code
        if error.message.startswith("Usage:"):  # the whole help, because a command is missing
            say(error.message, error=True)
        else:
            _fail(_misused(error), code)
    except EXPECTED as error:
        code = _fail(_describe(error), USER_ERROR)
    except (typer.Abort, KeyboardInterrupt) as error:
        code = _fail(f"interrupted {error.__cause__ or ''}", INTERRUPTED)
    sys.exit(code)


def _fail(message: str, code: int) -> int:
    print_error(message)
    return code


def _misused(error: TyperException) -> str:
    """Return what is wrong with a command line, and the command that prints its help."""
    if isinstance(error, typer.BadParameter) and error.message:  # from this program's own checks
        return error.message
    message = error.format_message()
    for pattern, sentence in SENTENCES:
        if found := re.fullmatch(pattern, message, flags=re.DOTALL):
            message = found.expand(sentence)
            break
    context = getattr(error, "ctx", None)
    return f"{message}; see: {context.command_path} -h" if context else message


def _describe(error: Exception) -> str:
    if isinstance(error, BrokenPipeError):
        # Nobody reads standard output any more: prevent another error when Python flushes it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
