"""Text and warnings that commands print."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from warehouse_core.wording import printable

MAX_LENGTH = 2000
"""Limit on the characters of an error message, which may quote a value as long as a file."""


def say(text: object, *, error: bool = False, bold: bool = False) -> None:
    """Print text, with control characters shown as escapes.

    Args:
        text: text to print, which may contain names from strangers.
        error: print on standard error.
        bold: print in bold if the stream is a terminal.
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


@contextmanager
def warnings_printed() -> Iterator[None]:
    """Print each distinct warning that is given inside the block, on one line each."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            for message in dict.fromkeys(str(each.message) for each in found):
                print_error(f"warning: {message}")


def printable_lines(text: str) -> str:
    """Return text with each line made ``printable``."""
    return "\n".join(map(printable, text.split("\n")))
