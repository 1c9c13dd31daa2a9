"""What commands print."""

from __future__ import annotations

import typer

from warehouse_core.wording import printable

MAX_LENGTH = 2000
"""Characters of an error message, which may quote a value as long as a file."""


def say(text: object, *, error: bool = False, bold: bool = False) -> None:
    """Print text; names in it may have any characters, and the terminal is not given its own.

    It is on standard error if it is an ``error``, and ``bold`` if the stream is a terminal.
    """
    lines = printable_lines(str(text))
    typer.echo(typer.style(lines, bold=True) if bold else lines, err=error)


def print_error(message: str) -> None:
    """Print a message on standard error as one line."""
    line = " ".join(message.split())
    if len(line) > MAX_LENGTH:
        line = f"{line[:MAX_LENGTH]}..."
    if line:  # an exception may have no message
        say(f"warehouse: {line}", error=True)


def printable_lines(text: str) -> str:
    """Return ``printable`` lines of text."""
    return "\n".join(map(printable, text.split("\n")))
