"""The contents of a report: answers, figures, examples, settings, and a table of all cases."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import version

from agents.evaluation.interval import CONFIDENCE, MIN_VALUES
from agents.evaluation.wording import mean, share
from agents.experiments.parameters import shown
from agents.experiments.store import Store
from agents.reports.analysis.answers import answers
from agents.reports.analysis.design import Design, described, make_design
from agents.reports.analysis.results import Experiment, Results
from agents.reports.examples import Example
from agents.reports.figures.pictures import pictures
from agents.reports.page import Page, Table
from warehouse_core.records.failure_modes import MODES
from warehouse_core.wording import counted

MAX_CASES = 200
"""In the table; the others are only in the file."""

MAX_MIXED = 4
"""Combinations that are named where their episodes are of several programs."""

METHODS = (
    f"Ranges in brackets, whiskers and bands are {CONFIDENCE:.0%} intervals, Wilson's of shares "
    f"and the studentised bootstrap's of means of at least {MIN_VALUES} values; p is that of "
    "McNemar's exact test, times the pairs of values where the two best were chosen from more."
)

MADE_WITH = ("warehouse-lab", "numpy", "scipy", "matplotlib")


def make_page(store: Store, examples: tuple[Example, ...]) -> Page:
    """Return the report on everything in a file of results.

    Raises:
        StoreError: there is no episode in it, or it cannot be read.
    """
    experiment = Experiment(store)
    design = make_design(experiment.cases)
    return Page(
        title=f"Report on {store.path.name}",
        summary=_summary(experiment, design),
        methods=METHODS,
        answers=answers(experiment, design),
        pictures=tuple(pictures(experiment)),
        settings=tuple(_settings(design)),
        table=_table(experiment, design),
        examples=examples,
        made_with=(
            ("Python", platform.python_version()),
            *((name, version(name)) for name in MADE_WITH),
            *((counted(number, "episode"), name) for name, number in store.episodes()),
        ),
    )


def _summary(experiment: Experiment, design: Design) -> str:
    """Return the number of episodes, their seeds and programs, and what is still missing."""
    everything = experiment.results(*experiment.cases)
    first, last = everything.seeds
    counts = [experiment.results(case_id).episodes for case_id in experiment.cases]
    parts = [
        f"{counted(everything.episodes, 'episode')} in "
        f"{counted(len(experiment.cases), 'combination')} of settings",
        f"seeds from {first} to {last}",
    ]
    if min(counts) < max(counts):
        parts.append(f"{min(counts):,} to {max(counts):,} episodes each")
    if experiment.unbegun:
        parts.append(f"{counted(experiment.unbegun, 'further combination')} not yet begun")
    names = [name for name, _ in experiment.store.episodes()]
    # The same program names more libraries where a case uses them.
    programs = [name for name in names if not any(each.startswith(f"{name}, ") for each in names)]
    if len(programs) > 1:
        parts.append(f"run by different programs: {'; '.join(programs)}")
    mixed = [number for number in experiment.store.mixed() if number in experiment.cases]
    if mixed:
        names = [_name_of(number, design) for number in mixed[:MAX_MIXED]]
        left = f" and {len(mixed) - len(names):,} more" if len(mixed) > len(names) else ""
        parts.append(f"which are mixed in {'; '.join(names)}{left}")
    return ", ".join(parts)


def _name_of(case_id: int, design: Design) -> str:
    """Return what differs in a case, in words."""
    labels = {each.name: design.labels[case_id][each.name] for each in design.factors}
    return described(labels) or "all of them"


def _settings(design: Design) -> Iterator[tuple[str, str]]:
    """Yield the parameters that differ with their values, and then the others."""
    for factor in design.factors:
        yield factor.name, ", ".join(map(shown, factor.values))
    for name, value in design.fixed.items():
        yield name, shown(value)


def _table(experiment: Experiment, design: Design) -> Table:
    """Return a line for each case: what differs, the number of episodes, and their results."""
    chosen = list(design.labels)[:MAX_CASES]
    results = {case_id: experiment.results(case_id) for case_id in chosen}
    modes = [mode for mode in MODES if any(mode in each.modes for each in results.values())]
    is_measured = any(each.is_measured for each in results.values())
    names = [factor.name for factor in design.factors]
    costs = ("seconds", "joules") if is_measured else ()
    rows = [
        (
            *(shown(design.labels[case_id][name]) for name in names),
            *_cells(each, is_measured),
            *(f"{each.modes.get(mode, 0):,}" for mode in modes),
        )
        for case_id, each in results.items()
    ]
    left = len(design.labels) - len(chosen)
    note = f"{counted(left, 'further combination')} in the file." if left else ""
    return Table(
        (*names, "episodes", "seeds", "success", "steps", *costs, *modes), tuple(rows), note
    )


def _cells(results: Results, with_costs: bool) -> Iterator[str]:
    first, last = results.seeds
    yield f"{results.episodes:,}"
    has_gaps = results.episodes < last - first + 1
    yield f"{first} to {last}{' with gaps' if has_gaps else ''}"
    yield share(results.success)
    yield mean(results.steps, "") if results.steps else shown(None)
    if with_costs:
        for interval in (results.seconds, results.joules):
            yield mean(interval, "") if interval and results.is_measured else shown(None)
