"""Lines of a text file from outside, read in bounded memory, with errors that say where.

Lines and columns are counted from 1, as editors do; columns are bytes.
"""

from __future__ import annotations

import re
from io import BufferedReader

from warehouse_core.errors import LayoutError

MAX_LINE = 1000
"""Bytes of a line."""

WHOLE = re.compile(r"[0-9]+")


def error_at(line: int, column: int, message: str) -> LayoutError:
    """Return the error of a place in a file."""
    return LayoutError(f"line {line}, column {column}: {message}")


def read_line(file: BufferedReader, number: int) -> str:
    """Read a line of a header or a scenario without its end and without a byte-order mark."""
    data = file.readline(MAX_LINE + 1)
    if len(data) > MAX_LINE:
        raise error_at(number, MAX_LINE + 1, f"the line is longer than MAX_LINE = {MAX_LINE} bytes")
    try:
        return data.decode("utf-8-sig" if number == 1 else "utf-8").rstrip(" \t\r\n")
    except UnicodeDecodeError as error:
        raise error_at(number, error.start + 1, "not UTF-8 text") from error


def expect(line: str, number: int, *wanted: str) -> None:
    """Refuse a line that is none of those wanted, however its words are spaced."""
    if " ".join(line.split()) not in wanted:
        allowed = " or ".join(map(repr, wanted))
        raise error_at(number, 1, f"{line!r} is not allowed; it must be {allowed}")


def whole_number_at(text: str, name: str, least: int, line: int, column: int) -> int:
    """Return the whole number that stands at a place."""
    if not WHOLE.fullmatch(text) or int(text) < least:
        raise error_at(
            line, column, f"{name} is {text!r}; it must be a whole number, at least {least}"
        )
    return int(text)
