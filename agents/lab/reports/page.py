"""Pages of HTML that load nothing from elsewhere, and the page of a report.

A page has sections with answers, figures, examples, tables and players. Its only script belongs to
the players. Names from users, such as the names of agents and layouts, are always escaped.
"""

from __future__ import annotations

import platform
import re
from base64 import b64encode
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from agents.errors import StoreError
from agents.lab.console.table import TextTable
from agents.lab.experiments.case import flags_of
from agents.lab.experiments.store import Store
from agents.lab.parameters import shown
from agents.lab.reports.answers import Answer, answers
from agents.lab.reports.examples import Example, find_examples, replay
from agents.lab.reports.figures import Picture, pictures
from agents.lab.reports.results import FLEETS, LONE, Experiment, Results
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES
from agents.lab.trials.rows import MODES_OF
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import style_rules
from warehouse_core.viz.player import player_frame
from warehouse_core.viz.player.page import digest, script
from warehouse_core.wording import counted, printable

MAX_CASES = 200
"""Maximum number of cases in the table; the others are only in the file of results."""

METHODS = (
    f"Ranges in brackets, whiskers and bands are {CONFIDENCE:.0%} intervals: Wilson intervals for "
    f"shares, and studentised bootstrap intervals for means of at least {MIN_VALUES} values. Where "
    "equal seeds are equal tasks, differences are computed seed by seed, with intervals by Bonett "
    "and Price for shares. No difference was found if the interval of the difference contains 0."
)

NUMBER = re.compile(r"-?\d[\d,.]*%?( .*)?")
"""Pattern for a number, with or without a unit and an interval."""

MAX_LETTERS = 60
"""Maximum length of a cell that is written on one line."""

MADE_WITH = ("warehouse-lab", "numpy", "matplotlib")


PROGRAMS = """
SELECT program, count(*) AS number FROM episodes JOIN cases ON id = case_id
GROUP BY program ORDER BY number DESC
"""
"""Query for the programs and the numbers of episodes that they have run."""


class Section(NamedTuple):
    """A part of a page with a heading.

    Attributes:
        title: Heading of the section.
        parts: Answers, figures, examples, tables and players. A table without a header has names
            and values.
        note: Sentence below the heading.
    """

    title: str
    parts: Sequence[Answer | Picture | Example | TextTable | Markup]
    note: str = ""

    @property
    def id(self) -> str:
        """The target of links to the section."""
        return "-".join(re.findall(r"\w+", self.title.lower()))


class Page(NamedTuple):
    """A page: its title, the lines below it, and its sections; ``methods`` are folded."""

    title: str
    intro: Sequence[str]
    sections: Sequence[Section]
    methods: str = ""


def make_page(store: Store, replays: bool | None = False) -> Page:
    """Return the report on a file of results.

    Args:
        store: file of results.
        replays: True if an episode with each outcome is to be run again and replayed; ``None``
            leaves out episodes of users' agents.

    Raises:
        StoreError: the file has no episodes.
    """
    parts = [each for kind in (LONE, FLEETS) if (each := Experiment(store, kind)).cases]
    if not parts:
        raise StoreError(f"{store.path}: the file has no episodes")
    wanted = [] if replays is False or parts[0].kind is not LONE else find_examples(parts[0])
    made_with = [
        ("Python", platform.python_version()),
        *((name, version(name)) for name in MADE_WITH),
        *((counted(number, "episode"), str(program)) for program, number in store.query(PROGRAMS)),
    ]
    sections = [
        Section("Answers", [answer for part in parts for answer in answers(part)]),
        Section("Figures", [picture for part in parts for picture in pictures(part)]),
        Section(
            "Examples",
            [replay(each, run_own_code=bool(replays)) for each in wanted],
            "The shortest episode with each outcome, run again from its seed.",
        ),
        Section("Settings", [TextTable((), [each for part in parts for each in _settings(part)])]),
        Section("All cases", [_table(part) for part in parts]),
        Section("Made with", [TextTable((), made_with)]),
    ]
    return Page(
        title=f"Report on {store.path.name}",
        intro=["; ".join(map(_summary, parts))],
        sections=[each for each in sections if each.parts],
        methods=METHODS,
    )


def _summary(experiment: Experiment) -> str:
    """Return the number of episodes, their seeds, and the number of missing combinations."""
    everything = experiment.results(*experiment.cases)
    counts = [experiment.results(case_id).episodes for case_id in experiment.cases]
    words = (
        f"{counted(everything.episodes, 'episode')}{experiment.kind.name} in "
        f"{counted(len(counts), 'combination')} of settings, "
        "seeds from {} to {}".format(*everything.seeds)
    )
    if min(counts) < max(counts):
        words += f", {min(counts):,} to {max(counts):,} episodes each"
    if experiment.unbegun:
        words += f", {counted(experiment.unbegun, 'further combination')} not yet started"
    return words


def _settings(experiment: Experiment) -> Iterator[tuple[str, str]]:
    """Yield names and values of the parameters that differ, and then of the other parameters."""
    for factor in experiment.design.factors:
        yield factor.name, ", ".join(map(shown, factor.values))
    for name, value in experiment.design.fixed.items():
        yield name, shown(value)


def _table(experiment: Experiment) -> TextTable:
    """Return a table with a row for each case: its settings, number of episodes and results."""
    design, kind = experiment.design, experiment.kind
    results = {each: experiment.results(each) for each in list(design.labels)[:MAX_CASES]}
    names = [factor.name for factor in design.factors]
    modes = [m for m in MODES_OF[kind.row] if any(m in each.modes for each in results.values())]
    measures = [m for m in kind.measures if any(each.has(m) for each in results.values())]

    def cells(case_id: int, each: Results) -> Iterator[str]:
        yield from (shown(design.labels[case_id][name]) for name in names)
        yield f"{each.episodes:,}"
        first, last = each.seeds
        yield f"{first} to {last}{' with gaps' if each.episodes < last - first + 1 else ''}"
        for measure in measures:
            interval = each.interval(measure) if each.has(measure) else None
            yield measure.words(interval) if interval else shown(None)
        yield from (f"{each.modes.get(mode, 0):,}" for mode in modes)

    left = len(design.labels) - len(results)
    note = f"The file has {counted(left, 'further combination')}." if left else ""
    columns = (measure.name.replace("_", " ") for measure in measures)
    header = (*names, "episodes", "seeds", *columns, *modes)
    return TextTable(header, [tuple(cells(*each)) for each in results.items()], caption=note)


def write_page(path: Path, page: Page) -> None:
    """Write a page, which loads nothing, and leave no incomplete file after an error."""
    parts = [part for section in page.sections for part in section.parts]
    has_players = any(isinstance(each, Markup) or getattr(each, "track", None) for each in parts)
    environment = Environment(
        loader=PackageLoader("agents.lab.reports", ""),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_shown,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "counted": counted, "data_uri": _data_uri, "flags": flags_of, "kinds": _kinds,
        "player": _player,
    }  # fmt: skip
    scripts = digest(script()) if has_players else ""
    text = environment.get_template("page.html").render(
        palette=Markup(style_rules()), scripts=scripts, page=page
    )
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")


def _shown(value: object) -> object:
    """Return a value for display: text without invisible characters, and markup unchanged."""
    is_text = isinstance(value, str) and not isinstance(value, Markup)
    return printable(str(value)) if is_text else value


def _player(example: Example) -> Markup:
    assert example.track is not None, "the template asks for a player only if there is a track"
    title = f"Replay of an episode that ended as {example.mode}: {example.sentence}"
    return Markup(player_frame([example.track], title=title))


def _data_uri(picture: Picture) -> str:
    return f"data:image/svg+xml;base64,{b64encode(picture.svg).decode('ascii')}"


def _kinds(table: TextTable) -> list[Markup]:
    """Return the HTML class of the cells of each column, which may be numbers or long texts."""
    columns = [{*column} - {"", shown(None)} for column in zip(*table.rows, strict=True)]
    kinds = [
        "number"
        if cells and all(map(NUMBER.fullmatch, cells))
        else "words"
        if max(map(len, cells), default=0) > MAX_LETTERS
        else ""
        for cells in columns or [set[str]()] * len(table.header)
    ]
    return [Markup(' class="{}"').format(kind) if kind else Markup() for kind in kinds]
