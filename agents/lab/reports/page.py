"""The report as one page of HTML, without anything loaded from elsewhere.

It has answers, figures, examples, settings, and a table of all cases. The only script is the one of
the players. Names given by users, of agents and layouts for example, are always escaped text.
"""

from __future__ import annotations

import platform
import re
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from agents.errors import StoreError
from agents.lab.experiments.case import flags_of
from agents.lab.experiments.store import Store
from agents.lab.parameters import shown
from agents.lab.reports.answers import Answer, answers
from agents.lab.reports.design import Design
from agents.lab.reports.examples import Example
from agents.lab.reports.figures import Picture, pictures
from agents.lab.reports.results import FLEETS, LONE, Experiment, ReportedMeasure, Results
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES
from agents.lab.trials.rows import MODES_OF
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import style_rules
from warehouse_core.viz.player import player_frame
from warehouse_core.viz.player.page import digest, script
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted, printable

MAX_CASES = 200
"""Cases in the table at most; the others are only in the file."""

METHODS = (
    f"Ranges in brackets, whiskers and bands are {CONFIDENCE:.0%} intervals: Wilson's for shares, "
    f"the studentised bootstrap's for means of at least {MIN_VALUES} values. Differences are taken "
    "seed by seed where equal seeds are equal tasks, with Bonett and Price's interval for shares. "
    "No difference was found if the interval of the difference contains 0."
)

NUMBER = re.compile(r"-?\d[\d,.]*%?( .*)?")

MADE_WITH = ("warehouse-lab", "numpy", "matplotlib")


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


def make_page(store: Store, examples: tuple[Example, ...]) -> Page:
    """Return the report on everything in a file of results, or raise if there is no episode."""
    parts = [each for kind in (LONE, FLEETS) if (each := Experiment(store, kind)).cases]
    if not parts:
        raise StoreError(f"{store.path}: there is no episode in it")
    return Page(
        title=f"Report on {store.path.name}",
        summary="; ".join(map(_summary, parts)),
        methods=METHODS,
        answers=tuple(answer for part in parts for answer in answers(part)),
        pictures=tuple(picture for part in parts for picture in pictures(part)),
        settings=tuple(setting for part in parts for setting in _settings(part.design)),
        tables=tuple(map(_table, parts)),
        examples=examples,
        made_with=(
            ("Python", platform.python_version()),
            *((name, version(name)) for name in MADE_WITH),
            *((counted(number, "episode"), name) for name, number in store.episodes()),
        ),
    )


def _summary(experiment: Experiment) -> str:
    """Return the number of episodes, their seeds, and what is still missing."""
    everything = experiment.results(*experiment.cases)
    first, last = everything.seeds
    counts = [experiment.results(case_id).episodes for case_id in experiment.cases]
    parts = [
        f"{counted(everything.episodes, 'episode')}{experiment.kind.name} in "
        f"{counted(len(experiment.cases), 'combination')} of settings",
        f"seeds from {first} to {last}",
    ]
    if min(counts) < max(counts):
        parts.append(f"{min(counts):,} to {max(counts):,} episodes each")
    if experiment.unbegun:
        parts.append(f"{counted(experiment.unbegun, 'further combination')} not yet begun")
    return ", ".join(parts)


def _settings(design: Design) -> Iterator[tuple[str, str]]:
    """Yield the parameters that differ with their values, and then the others."""
    for factor in design.factors:
        yield factor.name, ", ".join(map(shown, factor.values))
    for name, value in design.fixed.items():
        yield name, shown(value)


def _table(experiment: Experiment) -> Table:
    """Return a line for each case: what differs, the number of episodes, and their results."""
    design = experiment.design
    chosen = list(design.labels)[:MAX_CASES]
    results = {case_id: experiment.results(case_id) for case_id in chosen}
    modes = [
        mode
        for mode in MODES_OF[experiment.kind.row]
        if any(mode in each.modes for each in results.values())
    ]
    measures = [
        each
        for each in experiment.kind.measures
        if any(found.has(each) for found in results.values())
    ]
    names = [factor.name for factor in design.factors]
    rows = (
        (
            *(shown(design.labels[case_id][name]) for name in names),
            f"{each.episodes:,}",
            _seeds(each),
            *(_cell(each, measure) for measure in measures),
            *(f"{each.modes.get(mode, 0):,}" for mode in modes),
        )
        for case_id, each in results.items()
    )
    left = len(design.labels) - len(chosen)
    note = f"{counted(left, 'further combination')} in the file." if left else ""
    columns = (measure.name.replace("_", " ") for measure in measures)
    return Table((*names, "episodes", "seeds", *columns, *modes), tuple(rows), note)


def _cell(results: Results, measure: ReportedMeasure) -> str:
    interval = results.interval(measure)
    return measure.words(interval) if interval and results.has(measure) else shown(None)


def _seeds(results: Results) -> str:
    first, last = results.seeds
    has_gaps = results.episodes < last - first + 1
    return f"{first} to {last}{' with gaps' if has_gaps else ''}"


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
    """Return for each column whether its cells are numbers, perhaps with units or intervals."""
    columns = []
    for number in range(len(table.columns)):
        cells = {row[number] for row in table.rows} - {"", shown(None)}
        columns.append(bool(cells) and all(NUMBER.fullmatch(cell) for cell in cells))
    return columns
