"""The report as one page of HTML, without anything loaded from elsewhere.

The only script is the one of the players. Names given by users, of agents and layouts for example,
are always escaped text.
"""

from __future__ import annotations

import re
from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from agents.lab.experiments.case import flags_of
from agents.lab.parameters import shown
from agents.lab.reports.analysis.answers import Answer
from agents.lab.reports.examples import Example
from agents.lab.reports.figures.pictures import Picture
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import style_rules
from warehouse_core.viz.player import player_frame
from warehouse_core.viz.player.page import digest, script
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import printable

NUMBER = re.compile(r"[-+\u2212]?\d[\d,. ]*( ?%| ?[a-zA-Z/]{1,3})?( ?(\[.*\]|\(.*\)|\u00b1.*))?")
"""Cells that are aligned to the right: a number, perhaps with a unit or an interval."""

BLANK = {"", "-", shown(None)}


@dataclass(frozen=True, slots=True)
class Table:
    """The names of columns, rows with as many cells, and a note below, perhaps empty."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str


@dataclass(frozen=True, slots=True)
class Page:
    """The contents of the page: the summary tells the episodes, and the methods what ranges mean.

    There is a setting for each parameter, a table for each kind of episodes, an example for each
    failure mode, and the versions of the programs that it was made with.
    """

    title: str
    summary: str
    methods: str
    answers: tuple[Answer, ...]
    pictures: tuple[Picture, ...]
    settings: tuple[tuple[str, str], ...]
    tables: tuple[Table, ...]
    examples: tuple[Example, ...]
    made_with: tuple[tuple[str, str], ...]


def write_page(path: Path, page: Page) -> None:
    """Write the page; the file is complete or not there."""
    has_players = any(example.track for example in page.examples)
    write_template(path, "page.html", page.title, has_players, page=page)


def write_template(
    path: Path, template: str, title: str, has_players: bool, **values: object
) -> None:
    """Write a page by a template of this folder; the file is complete or not there.

    Its policy has to allow the script of players; ``values`` are what the template names.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_shown,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "data_uri": _data_uri, "flags": flags_of, "numeric": _numeric, "player": _player,
    }  # fmt: skip
    scripts = digest(script()) if has_players else ""
    environment.globals |= {"palette": Markup(style_rules()), "scripts": scripts, "title": title}
    text = environment.get_template(template).render(values)
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")


def _shown(value: object) -> object:
    """Return a value as it is shown: text without invisible characters, markup as it is."""
    is_text = isinstance(value, str) and not isinstance(value, Markup)
    return printable(str(value)) if is_text else value


def _player(example: Example) -> Markup:
    assert example.track is not None, "only asked for if there is one"
    title = f"Replay of an episode that ended as {example.found.mode}: {example.sentence}"
    return player_of(example.track, title)


def player_of(track: Track, title: str) -> Markup:
    """Return the player of an episode, as part of a page."""
    return Markup(player_frame([track], title=title))


def _data_uri(data: bytes, kind: str) -> str:
    return f"data:{kind};base64,{b64encode(data).decode('ascii')}"


def _numeric(table: Table) -> list[bool]:
    """Return for each column whether it has numbers."""
    columns = []
    for cells in zip(*table.rows, strict=True):
        known = [cell.strip() for cell in cells if cell.strip() not in BLANK]
        columns.append(bool(known) and all(map(NUMBER.fullmatch, known)))
    return columns or [False] * len(table.columns)
