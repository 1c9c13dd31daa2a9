"""Lines of a third-party text file, read in bounded memory, with errors that give the place.

Lines and columns are counted from 1, as editors do; columns are bytes.
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
    """Open a file; each ``LayoutError`` then starts with its name."""
    with open_file(path) as file:
        try:
            yield file
        except LayoutError as error:
            raise LayoutError(f"{path}: {error}") from error


def error_at(line: int, column: int, message: str) -> LayoutError:
    """Return an error at a place in a file."""
    return LayoutError(f"line {line}, column {column}: {message}")


def read_line(file: BufferedReader, number: int) -> str:
    """Read a line without its trailing blanks, line end and byte-order mark.

    Raises:
        LayoutError: it is longer than ``MAX_LINE``, or not UTF-8.
    """
    return _decoded(file.readline(MAX_LINE + 1), number)


def read_lines(
    file: BufferedReader, number: int, limit: str, most: int
) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line from ``number`` on that is not blank.

    Raises:
        LayoutError: there are more than ``most`` lines, blank ones included, the error naming the
            ``limit``; or as for ``read_line``.
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
    """Raise ``LayoutError`` if a line, with single spaces, is none of ``wanted``."""
    if " ".join(line.split()) not in wanted:
        allowed = " or ".join(map(repr, wanted))
        raise error_at(number, 1, f"{line!r} is not allowed; it must be {allowed}")


def whole_number_at(text: str, name: str, minimum: int, line: int, column: int) -> int:
    """Return the whole number at a place, at least ``minimum``; raise ``LayoutError`` otherwise."""
    if not _WHOLE.fullmatch(text) or int(text) < minimum:
        raise error_at(
            line, column, f"{name} is {text!r}; it must be a whole number, at least {minimum}"
        )
    return int(text)
