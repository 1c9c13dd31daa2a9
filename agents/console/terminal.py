"""What commands print."""

from __future__ import annotations

import typer

from warehouse_core.wording import printable


def say(text: object, *, error: bool = False, bold: bool = False) -> None:
    """Print text; names in it may have any characters, and the terminal is not given its own.

    Args:
        text: of one or more lines.
        error: print on standard error.
        bold: print it in bold, if the stream is a terminal.
    """
    lines = printable_lines(str(text))
    typer.echo(typer.style(lines, bold=True) if bold else lines, err=error)


def printable_lines(text: str) -> str:
    """Return ``printable`` lines of text."""
    return "\n".join(map(printable, text.split("\n")))
