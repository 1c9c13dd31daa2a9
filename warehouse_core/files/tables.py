"""Tables that people touch, as comma-separated values.

Spreadsheets save them with other delimiters and encodings, and write ``1`` as ``1.0`` or ``1,0``.
All of these are read.
"""

from __future__ import annotations

import csv
import math
import os
import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from io import StringIO
from pathlib import Path
from typing import TypeVar

from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file
from warehouse_core.wording import counted, printable, spreadsheet_text, without_guard

T = TypeVar("T")

MAX_COLUMNS = 1_000
"""Limit on the columns of a table."""

DELIMITERS = ",;\t"

SEPARATOR = re.compile(r"sep=(.)\r?\n")
"""First line by which Excel knows the delimiter."""

WHOLE = re.compile(r"([0-9]{1,18})([.,]0*)?")


def read_table(
    path: str | os.PathLike[str],
    needed: Collection[str],
    max_bytes: int,
    made: Callable[[dict[str, str]], T],
    key: str | None = None,
    optional: Collection[str] = (),
) -> Iterator[T]:
    r"""Yield what a function makes of each line: of the fields by column, without outer blanks.

    Args:
        path: file, in UTF-8 or with the byte-order mark of UTF-16.
        needed: columns that must be there, compared without case.
        max_bytes: limit on the bytes of the file.
        made: function of the fields, which raises ``ValueError`` if one of them is bad.
        key: column in which no value may occur twice.
        optional: further columns that are compared without case.

    Raises:
        ValueError: the file is not such a table; the message names the line.
        OSError: the file is longer than ``max_bytes``, or cannot be read.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core.files.tables import read_table
        >>> size = Path("late.csv").write_text("Submission;Days\nann.py; 1\n")
        >>> list(read_table("late.csv", ["submission", "days"], 1000, dict))
        [{'submission': 'ann.py', 'days': '1'}]
    """
    text = _decoded(read_file(path, max_bytes))
    before = SEPARATOR.match(text)
    text = text[before.end() :] if before else text
    delimiter = before[1] if before else _delimiter(text.partition("\n")[0], needed)
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, strict=True)
    seen = dict[str, int]()
    try:
        columns = _columns(next(reader, []), needed, optional)
        for fields in reader:
            line, row = reader.line_num + bool(before), _row(fields, columns)
            if row is None:
                continue
            if key is not None and seen.setdefault(row[key], line) != line:
                raise ValueError(f"{key} {row[key]!r} is in line {seen[row[key]]} too")
            yield made(row)
    except (ValueError, csv.Error) as error:
        raise ValueError(f"line {max(reader.line_num, 1) + bool(before)}: {error}") from None


def _decoded(data: bytes) -> str:
    is_wide = data.startswith((BOM_UTF16_LE, BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if is_wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        line, wrong = data.count(b"\n", 0, error.start) + 1, error.object[error.start]
        raise ValueError(
            f"line {line}: can't decode byte {wrong:#x}; save the table as CSV in UTF-8"
        ) from None


def _delimiter(line: str, needed: Collection[str]) -> str:
    """Return the delimiter by which a line has most of the needed columns."""
    names = {name.casefold() for name in needed}

    def found(delimiter: str) -> int:
        return sum(each.strip(' "\r').casefold() in names for each in line.split(delimiter))

    return max(DELIMITERS, key=found)


def _columns(names: Sequence[str], needed: Collection[str], optional: Collection[str]) -> list[str]:
    if len(names) > MAX_COLUMNS:
        raise ValueError(f"{len(names):,} columns are more than MAX_COLUMNS = {MAX_COLUMNS}")
    known = {name.casefold(): name for name in [*optional, *needed]}
    columns = [known.get(name.strip().casefold(), name.strip()) for name in names]
    for name in needed:
        if columns.count(name) != 1:
            problem = "there twice" if name in columns else "missing"
            raise ValueError(f"the column {name!r} is {problem}")
    return columns


def _row(fields: Sequence[str], columns: Sequence[str]) -> dict[str, str] | None:
    """Return the fields of a line by column, or ``None`` for a line of blanks."""
    found = [without_guard(each.strip()) for each in fields]
    while len(found) > len(columns) and not found[-1]:
        found.pop()
    if not any(found):
        return None
    if len(found) != len(columns):
        raise ValueError(f"{counted(len(found), 'field')}, not {len(columns)}")
    return dict(zip(columns, found, strict=True))


def whole_in(row: dict[str, str], column: str, least: int = 0, most: int | None = None) -> int:
    """Return the whole number in a field, or raise ``ValueError``."""
    text = row[column]
    found = WHOLE.fullmatch(text)
    if found is None or int(found[1]) < least or (most is not None and int(found[1]) > most):
        allowed = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ValueError(f"{column} is {text[:20]!r}; allowed: a whole number {allowed}")
    return int(found[1])


def number_in(row: dict[str, str], column: str) -> float:
    """Return the finite number in a field, which may have a decimal comma, or ``ValueError``."""
    text = row[column]
    try:
        number = float(text.replace(",", ".", 1))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{column} is {text[:20]!r}; allowed: a number")
    return number


def write_table(
    path: str | os.PathLike[str], columns: Sequence[str], lines: Iterable[Sequence[object]]
) -> None:
    """Write lines below the names of columns; after an error there is no incomplete file.

    ``None`` and NaN become empty fields. Texts are escaped so that no spreadsheet runs one as a
    formula. The file begins with a byte-order mark if there are characters beyond ASCII, because
    Excel would otherwise show others.
    """
    with atomic_path(Path(path)) as part:
        with part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(map(_field, line) for line in lines)
        data = part.read_bytes()
        if not data.isascii():
            part.write_bytes(BOM_UTF8 + data)


def _field(value: object) -> object:
    if isinstance(value, str):
        return spreadsheet_text(printable(value))
    return None if isinstance(value, float) and math.isnan(value) else value
