"""The report as a single HTML page that loads nothing from elsewhere.

The page has answers, figures, examples, settings and a table of all cases. Its only script belongs
to the replay players. Names from users, such as the names of agents and layouts, are always
escaped.
"""

from __future__ import annotations

import platform
import re
from base64 import b64encode
from collections import Counter
from collections.abc import Iterable, Iterator
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
from warehouse_core.viz.tracks.track import Track
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

MADE_WITH = ("warehouse-lab", "numpy", "matplotlib")


class Page(NamedTuple):
    """The contents of the page, in its order; settings and programs are names and values."""

    title: str
    summary: str
    methods: str
    answers: tuple[Answer, ...]
    pictures: tuple[Picture, ...]
    examples: tuple[Example, ...]
    settings: tuple[tuple[str, str], ...]
    tables: tuple[TextTable, ...]
    made_with: tuple[tuple[str, str], ...]


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
    return Page(
        title=f"Report on {store.path.name}",
        summary="; ".join(map(_summary, parts)),
        methods=METHODS,
        answers=tuple(answer for part in parts for answer in answers(part)),
        pictures=tuple(picture for part in parts for picture in pictures(part)),
        examples=tuple(replay(each, run_own_code=bool(replays)) for each in wanted),
        settings=tuple(setting for part in parts for setting in _settings(part)),
        tables=tuple(map(_table, parts)),
        made_with=(
            ("Python", platform.python_version()),
            *((name, version(name)) for name in MADE_WITH),
            *_programs(store, parts),
        ),
    )


def _programs(store: Store, parts: Iterable[Experiment]) -> Iterator[tuple[str, str]]:
    """Yield the number of episodes of each program and its name, most episodes first."""
    names, counts = store.programs(), Counter[str]()
    for part in parts:
        for case_id in part.cases:
            counts[names[case_id]] += part.results(case_id).episodes
    for name, count in counts.most_common():
        yield counted(count, "episode"), name


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
    """Write the page as a whole, so that no incomplete file is left after an error."""
    has_players = any(example.track for example in page.examples)
    write_template(path, "page.html", page.title, has_players, page=page)


def write_template(
    path: Path, template: str, title: str, has_players: bool, **values: object
) -> None:
    """Write a page with a template of this folder, and leave no incomplete file after an error.

    Args:
        path: Path of the page.
        template: File name of the template.
        title: Title of the page.
        has_players: True if the security policy of the page must allow the players' script.
        values: Variables of the template.
    """
    environment = Environment(
        loader=PackageLoader("agents.lab.reports", ""),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_shown,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "counted": counted, "data_uri": _data_uri, "flags": flags_of, "numeric": _numeric,
        "player": _player,
    }  # fmt: skip
    scripts = digest(script()) if has_players else ""
    environment.globals |= {"palette": Markup(style_rules()), "scripts": scripts, "title": title}
    text = environment.get_template(template).render(values)
    with atomic_path(path) as part:
        part.write_text(text, encoding="utf-8")


def _shown(value: object) -> object:
    """Return a value for display: text without invisible characters, and markup unchanged."""
    is_text = isinstance(value, str) and not isinstance(value, Markup)
    return printable(str(value)) if is_text else value


def _player(example: Example) -> Markup:
    assert example.track is not None, "the template asks for a player only if there is a track"
    title = f"Replay of an episode that ended as {example.mode}: {example.sentence}"
    return player_of(example.track, title)


def player_of(track: Track, title: str) -> Markup:
    """Return the HTML of a replay player for an episode."""
    return Markup(player_frame([track], title=title))


def _data_uri(picture: Picture) -> str:
    return f"data:image/svg+xml;base64,{b64encode(picture.svg).decode('ascii')}"


def _numeric(table: TextTable) -> list[bool]:
    """Return whether the cells of each column are numbers."""
    columns = ([row[number] for row in table.rows] for number in range(len(table.header)))
    found = [{*column} - {"", shown(None)} for column in columns]
    return [bool(cells) and all(map(NUMBER.fullmatch, cells)) for cells in found]
