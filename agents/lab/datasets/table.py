"""Results of a sweep as one CSV or Parquet table.

A line is an episode: its settings, a column for each, its outcome, and the program that ran it.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, get_type_hints

from agents.errors import StoreError
from agents.lab.experiments.case import TILES, Case, row_type
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row
from warehouse_core.extras import install_command
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import spreadsheet_text

ROWS_END = "/"
"""Sign between the rows of a layout, so that an episode is one line of text."""

CSV, PARQUET = ".csv", ".parquet"

LINES_AT_ONCE = 50_000
"""Lines that a Parquet file is written by, so that a large table takes little memory."""

TYPES = {int: "int", float: "float", str: "str", int | None: "int", float | None: "float"}

TableLine = tuple[Any, ...]


def save_table(target: Path, results: Path, suffix: str) -> None:
    """Write the episodes of a sweep as one table, ``CSV`` or ``PARQUET``, whole or not at all."""
    write = {CSV: _write_csv, PARQUET: _write_parquet}[suffix]
    with Store(results, read_only=True) as store, atomic_path(target) as part:
        columns = columns_of(store)
        write(part, columns, lines_of(store, columns))


def columns_of(store: Store) -> dict[str, str]:
    """Return the columns of the table and their types: settings, results and program.

    Each column belongs to one case or more; it is empty in the lines of the others. Types are
    ``"str"``, ``"bool"``, ``"int"`` or ``"float"``. Rows that no sweep has written are a
    ``StoreError``.
    """
    store.check_rows()
    types: dict[str, str] = {}
    cases = store.cases().values()
    for case in cases:
        for name in case:
            kind = type(_plain(case, name)).__name__
            if types.setdefault(name, kind) != kind:
                raise StoreError(f"{store.path}: {name} has several types, one is {kind}")
    for each in dict.fromkeys(map(row_type, cases)) or [Row]:
        hints = get_type_hints(each)
        types |= {name: TYPES[hints[name]] for name in each._fields}
    return types | {"program": "str"}


def lines_of(store: Store, columns: dict[str, str]) -> Iterator[TableLine]:
    """Yield the lines of the table, case by case and seed by seed."""
    for case_id, case in store.cases().items():
        settings = {name: _plain(case, name) for name in case}
        for row, program in store.rows(case_id, row_type(case)):
            line = settings | row._asdict() | {"program": program}
            yield tuple(map(line.get, columns))


def _plain(case: Case, name: str) -> Any:
    """Return a setting as one value; ``None`` if it does not apply to the case."""
    value = case.get(name)
    if name == TILES and value is not None:
        return ROWS_END.join(value)
    if isinstance(value, str):  # the name of a file may have bytes that are no text
        return value.encode(errors="backslashreplace").decode()
    return value


def _write_csv(path: Path, columns: dict[str, str], lines: Iterator[TableLine]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(map(_safe, columns))
        writer.writerows(map(_safe, line) for line in lines)


def _safe(value: Any) -> Any:
    """Return a value that no spreadsheet takes for a formula."""
    return spreadsheet_text(value) if isinstance(value, str) else value


def _write_parquet(path: Path, columns: dict[str, str], lines: Iterator[TableLine]) -> None:
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise StoreError(f"Parquet needs pyarrow: {install_command('parquet')}") from None
    kinds = {"str": pa.string(), "bool": pa.bool_(), "int": pa.int64(), "float": pa.float64()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in columns.items()])
    with parquet.ParquetWriter(path, schema) as writer:
        while some := list(islice(lines, LINES_AT_ONCE)):
            values = [list(column) for column in zip(*some, strict=True)]
            arrays = [pa.array(*column) for column in zip(values, schema.types, strict=True)]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
