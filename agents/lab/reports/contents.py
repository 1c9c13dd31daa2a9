"""The contents of a report: answers, figures, examples, settings, and a table of all cases."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import version

from agents.errors import StoreError
from agents.lab.experiments.store import Store
from agents.lab.parameters import shown
from agents.lab.reports.analysis.answers import answers
from agents.lab.reports.analysis.design import Design
from agents.lab.reports.analysis.results import FLEETS, LONE, Experiment, ReportedMeasure, Results
from agents.lab.reports.examples import Example
from agents.lab.reports.figures.pictures import pictures
from agents.lab.reports.page import Page, Table
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES
from agents.lab.trials.rows import MODES_OF
from warehouse_core.wording import counted

MAX_CASES = 200
"""Cases in the table at most; the others are only in the file."""

MAX_MIXED = 4
"""Combinations with episodes of several programs that are named at most."""

METHODS = (
    f"Ranges in brackets, whiskers and bands are {CONFIDENCE:.0%} intervals, Wilson's of shares "
    f"and the studentised bootstrap's of means of at least {MIN_VALUES} values; p is that of "
    "McNemar's exact test, times the pairs of values where the two best were chosen from more."
)

MADE_WITH = ("warehouse-lab", "numpy", "scipy", "matplotlib")


def make_page(store: Store, examples: tuple[Example, ...]) -> Page:
    """Return the report on everything in a file of results, or raise if there is no episode."""
    parts = [each for kind in (LONE, FLEETS) if (each := Experiment(store, kind)).cases]
    if not parts:
        raise StoreError(f"{store.path}: there is no episode in it")
    return Page(
        title=f"Report on {store.path.name}",
        summary="; ".join([*map(_summary, parts), *_programs(store)]),
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
    mixed = [number for number in experiment.store.mixed() if number in experiment.cases]
    if mixed:
        names = [experiment.design.name_of(number) or "all of them" for number in mixed[:MAX_MIXED]]
        left = f" and {len(mixed) - len(names):,} more" if len(mixed) > len(names) else ""
        parts.append(f"episodes of different programs mixed in {'; '.join(names)}{left}")
    return ", ".join(parts)


def _programs(store: Store) -> Iterator[str]:
    """Yield the names of the programs that have run the episodes, if they are different ones."""
    names = [name for name, _ in store.episodes()]
    # The same program names more libraries where a case uses them.
    programs = [name for name in names if not any(each.startswith(f"{name}, ") for each in names)]
    if len(programs) > 1:
        yield f"run by different programs: {'; '.join(programs)}"


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
    is_measured = any(each.is_measured for each in results.values())
    measures = [each for each in experiment.kind.measures if is_measured or not each.is_physical]
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
    columns = (measure.column for measure in measures)
    return Table((*names, "episodes", "seeds", *columns, *modes), tuple(rows), note)


def _cell(results: Results, measure: ReportedMeasure) -> str:
    interval = results.interval(measure)
    if interval is None or (measure.is_physical and not results.is_measured):
        return shown(None)
    return measure.words(interval)


def _seeds(results: Results) -> str:
    first, last = results.seeds
    has_gaps = results.episodes < last - first + 1
    return f"{first} to {last}{' with gaps' if has_gaps else ''}"
