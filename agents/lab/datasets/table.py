"""The results of a sweep as one CSV table.

Each line describes an episode by its settings, its results and the program that ran it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from agents.lab.experiments.case import TILES, Case, row_type
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row
from warehouse_core.files.tables import write_table

ROWS_END = "/"
"""Separator between the rows of a layout, so that each episode is a single line of text."""

GRID = "grid"
MEASURED = ("seconds", "joules", "joules_per_delivery")
"""The backend that measures neither time nor energy, and the results that are empty for it."""

TableLine = tuple[Any, ...]


def save_table(target: Path, results: Path) -> None:
    """Write the episodes of a sweep as one table, and leave no incomplete file after an error."""
    with Store(results, read_only=True) as store:
        columns = columns_of(store)
        write_table(target, columns, lines_of(store, columns))


def columns_of(store: Store) -> list[str]:
    """Return the names of the table's columns: settings, results and program.

    A cell is empty if the column does not apply to the case of its line.
    """
    cases = store.cases().values()
    settings = (name for case in cases for name in case)
    kinds = dict.fromkeys(map(row_type, cases)) or [Row]
    results = (name for kind in kinds for name in kind._fields)
    return [*dict.fromkeys([*settings, *results]), "program"]


def lines_of(store: Store, columns: list[str]) -> Iterator[TableLine]:
    """Yield the lines of the table, case by case and seed by seed."""
    programs = store.programs()
    for case_id, case in store.cases().items():
        settings = {name: _plain(case, name) for name in case}
        for row in store.rows(case_id, row_type(case)):
            line = settings | row._asdict() | {"program": programs.get(case_id)}
            if case.get("backend") == GRID:
                line |= dict.fromkeys(MEASURED)
            yield tuple(map(line.get, columns))


def _plain(case: Case, name: str) -> Any:
    """Return a setting as a single value, or ``None`` if it does not apply to the case."""
    value = case.get(name)
    return ROWS_END.join(value) if name == TILES and value is not None else value
