"""The report as one page of HTML: nothing in it is run, and nothing is loaded from elsewhere.

What users have named, such as agents and layouts, stands in it as text whatever it is.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from agents.experiments.case import flags_of
from agents.experiments.parameters import shown
from agents.reports.analysis.answers import Answer
from agents.reports.examples import Example
from agents.reports.figures.pictures import Picture
from warehouse_core.files.atomic import atomic_path

TEMPLATE = "page.html"

NUMBER = re.compile(r"[-+\u2212]?\d[\d,. ]*( ?%| ?[a-zA-Z/]{1,3})?( ?(\[.*\]|\(.*\)|\u00b1.*))?")
"""What stands to the right in its column: a number, perhaps with a unit or an interval."""

BLANK = {"", "-", shown(None)}


@dataclass(frozen=True, slots=True)
class Table:
    """Columns by name, rows with as many cells, and a note below, perhaps empty."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str


@dataclass(frozen=True, slots=True)
class Page:
    """Everything that the page says.

    Attributes:
        title: of the page.
        summary: how many episodes there are, and of which seeds.
        methods: what brackets and whiskers are.
        answers: the questions and what the results say to them.
        pictures: the figures.
        settings: the name of each and its value or values.
        table: of all cases.
        examples: of the failure modes.
        made_with: programs and their versions.
    """

    title: str
    summary: str
    methods: str
    answers: tuple[Answer, ...]
    pictures: tuple[Picture, ...]
    settings: tuple[tuple[str, str], ...]
    table: Table
    examples: tuple[Example, ...]
    made_with: tuple[tuple[str, str], ...]


def write_page(path: Path, page: Page) -> None:
    """Write the page; the file appears whole or not at all.

    Raises:
        OSError: the file cannot be written.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_visible,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"data_uri": _data_uri, "flags": flags_of}
    numeric = [_is_numeric(cells) for cells in zip(*page.table.rows, strict=True)]
    text = environment.get_template(TEMPLATE).render(
        page=page, numeric=numeric or [False] * len(page.table.columns)
    )
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")


def _visible(value: Any) -> Any:
    """Return text with a space for each character that nobody sees and a page may not hold."""
    if not isinstance(value, str) or value.isprintable():
        return value
    return "".join(character if character.isprintable() else " " for character in value)


def _data_uri(data: bytes, kind: str) -> str:
    return f"data:{kind};base64,{b64encode(data).decode('ascii')}"


def _is_numeric(cells: Sequence[str]) -> bool:
    known = [cell for cell in cells if cell.strip() not in BLANK]
    return bool(known) and all(NUMBER.fullmatch(cell.strip()) for cell in known)
