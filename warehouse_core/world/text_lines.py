"""Lines of an untrusted text file, read in bounded memory, with errors that name the place.

Lines and columns are counted from 1, as in editors. A column is a byte.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader

from warehouse_core.errors import LayoutError
from warehouse_core.files.reading import open_file

MAX_LINE = 1000
"""Limit on the bytes of a line."""

_WHOLE = re.compile(r"[0-9]+")


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[BufferedReader]:
    """Open a file, and put its name in front of every ``LayoutError`` of the block."""
    with open_file(path) as file:
        try:
            yield file
        except LayoutError as error:
            raise LayoutError(f"{path}: {error}") from error


def error_at(line: int, column: int, message: str) -> LayoutError:
    """Return an error at a place in a file."""
    return LayoutError(f"line {line}, column {column}: {message}")


def read_line(file: BufferedReader, number: int) -> str:
    """Return the next line without its trailing blanks, line end and byte-order mark.

    Raises:
        LayoutError: the line is longer than ``MAX_LINE``, or not UTF-8.
    """
    return _decoded(file.readline(MAX_LINE + 1), number)


def read_lines(
    file: BufferedReader, number: int, limit: str, most: int
) -> Iterator[tuple[int, str]]:
    """Yield the number and text of each line that is not blank.

    Args:
        file: file to read.
        number: number of the next line.
        limit: name of the limit, for the error message.
        most: limit on the number of lines, including blank lines.

    Raises:
        LayoutError: there are more than ``most`` lines, or ``read_line`` fails.
    """
    end = number + most
    while data := file.readline(MAX_LINE + 1):
        if number == end:
            raise error_at(number, 1, f"more than {limit} = {most} lines")
        line = _decoded(data, number)
        if line:
            yield number, line
        number += 1


def _decoded(data: bytes, number: int) -> str:
    if len(data) > MAX_LINE:
        raise error_at(number, MAX_LINE + 1, f"the line is longer than MAX_LINE = {MAX_LINE} bytes")
    try:
        return data.decode("utf-8-sig" if number == 1 else "utf-8").rstrip(" \t\r\n")
    except UnicodeDecodeError as error:
        raise error_at(number, error.start + 1, "not UTF-8 text") from error


def expect_line(line: str, number: int, *wanted: str) -> None:
    """Raise ``LayoutError`` unless a line, with single spaces, is one of ``wanted``."""
    if " ".join(line.split()) not in wanted:
        allowed = " or ".join(map(repr, wanted))
        raise error_at(number, 1, f"{line!r} is not allowed; it must be {allowed}")


def whole_number_at(text: str, name: str, minimum: int, line: int, column: int) -> int:
    """Return a whole number, or raise ``LayoutError`` if it is invalid or below ``minimum``."""
    if not _WHOLE.fullmatch(text) or int(text) < minimum:
        raise error_at(
            line, column, f"{name} is {text!r}; it must be a whole number, at least {minimum}"
        )
    return int(text)
