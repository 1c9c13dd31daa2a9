"""Tables in the forms in which Excel and LibreOffice save them."""

import csv
import re
from collections.abc import Callable
from io import StringIO
from pathlib import Path

Rows = list[list[str]]


def joined(rows: Rows, delimiter: str = ",", quoting: int = csv.QUOTE_MINIMAL) -> str:
    file = StringIO()
    ending = "\r\n"
    csv.writer(file, delimiter=delimiter, quoting=quoting, lineterminator=ending).writerows(rows)
    return file.getvalue()


def with_numbers(rows: Rows, ending: str) -> Rows:
    """Return rows with a decimal ending of each whole number."""
    return [
        [f"{each}{ending}" if re.fullmatch(r"\d{1,9}", each) else each for each in row]
        for row in rows
    ]


FORMS: dict[str, Callable[[Rows], bytes]] = {
    "byte-order mark": lambda rows: joined(rows).encode("utf-8-sig"),
    "semicolons and commas in numbers": lambda rows: joined(
        [[re.sub(r"^(\d+)\.(\d+)$", r"\1,\2", each) for each in row] for row in rows], ";"
    ).encode("utf-8-sig"),
    "tabs": lambda rows: joined(rows, "\t").encode(),
    "quotes": lambda rows: joined(rows, quoting=csv.QUOTE_ALL).encode(),
    "UTF-16": lambda rows: joined(rows, "\t").encode("utf-16"),
    "decimals": lambda rows: joined(with_numbers(rows, ".0")).encode(),
    "decimal commas": lambda rows: joined(with_numbers(rows, ",0"), ";").encode(),
    "empty columns and rows": lambda rows: joined(
        [*([*row, "", ""] for row in rows), [""] * 9]
    ).encode(),
    "a line with the delimiter": lambda rows: b"sep=|\r\n" + joined(rows, "|").encode(),
    "blanks and capitals": lambda rows: joined(
        [[f" {each.upper()} " for each in rows[0]], *([f"{each} " for each in r] for r in rows[1:])]
    ).encode(),
}
"""Functions of rows that give the content of a file, by what is special about it."""


def save_again(path: Path, form: str) -> None:
    """Replace a table with the same table in another form."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.reader(file))
    path.write_bytes(FORMS[form](rows))
