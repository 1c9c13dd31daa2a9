"""The results of an experiment: one SQLite file with a row for each episode.

Rows are written as episodes finish, and survive the end of the program. Every batch of rows is one
transaction, which is on the disk before the next one begins. The key of a row is its case and its
seed, so that no episode is stored twice. One program has run all episodes of a case.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args, get_type_hints

from agents.errors import StoreError
from agents.lab.experiments.case import Case, in_words, key_of, read_case
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from warehouse_core.files.reading import not_a_file

TIMEOUT = 30.0
"""Seconds to wait while another program writes to the same file."""

TYPES = {
    kind: {name: get_args(each) or (each,) for name, each in get_type_hints(kind).items()}
    for kind in (Row, FleetRow)
}
"""Types that each field of a row may have."""

COLUMNS = TYPES[Row] | TYPES[FleetRow]
"""Columns of an episode; the columns that only the other type of row has are empty."""

_COLUMNS = ", ".join(f"{name} {'REAL' if float in each else ''}" for name, each in COLUMNS.items())

TABLES = [
    "CREATE TABLE cases (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE, program TEXT)",
    f"CREATE TABLE episodes (case_id INTEGER, {_COLUMNS}, "
    "PRIMARY KEY (case_id, seed)) WITHOUT ROWID",
]
"""Statements that create the tables in an empty file."""

BELOW_ZERO, MAX_REAL = {"battery_left"}, 1e30
"""Integer fields of a row that may be negative, and largest absolute value of a real number."""


def is_whole(row: AnyRow) -> bool:
    """Return whether a sweep can have written a row; reports rely on it."""
    return row.mode in MODES_OF[type(row)] and all(
        type(value) in types
        and (type(value) is not float or abs(value) <= MAX_REAL)
        and (type(value) is not int or value >= 0 or name in BELOW_ZERO)
        for (name, types), value in zip(TYPES[type(row)].items(), row, strict=True)
    )


class Store:
    """A file of results, which is created if it does not exist; a context manager.

    Every failure, such as a damaged file or a full disk, raises a ``StoreError`` that names the
    file.

    Args:
        path: Path of the file.
        read_only: Do not create or change the file. It needs no write permission then.
    """

    def __init__(self, path: str | Path, *, read_only: bool = False) -> None:
        self.path = Path(path)
        if (kind := not_a_file(self.path)) is not None:
            raise StoreError(f"{path}: {kind}")
        if read_only and not self.path.exists():
            raise StoreError(f"{path}: there is no such file")
        with self._errors_reported():
            self._connection = sqlite3.connect(path, TIMEOUT, isolation_level=None)
        try:
            self._prepare(read_only=read_only)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def case_ids(self, cases: Sequence[Case]) -> list[int]:
        """Return the numbers of some cases, after adding those that are new."""
        keys = [(key_of(case),) for case in cases]
        with self._transaction():
            self._connection.executemany("INSERT OR IGNORE INTO cases (settings) VALUES (?)", keys)
        ids = dict(self.query("SELECT settings, id FROM cases"))
        return [ids[key] for (key,) in keys]

    def count(self, case_id: int, seeds: range) -> int:
        """Return the number of stored episodes of a case with the given seeds."""
        statement = "SELECT count(*) FROM episodes WHERE case_id = ? AND seed >= ? AND seed < ?"
        return int(next(self.query(statement, case_id, seeds.start, seeds.stop))[0])

    def seeds_done(self, case_id: int, seeds: range) -> set[int]:
        """Return the seeds, among the given ones, whose episodes of a case are stored."""
        statement = "SELECT seed FROM episodes WHERE case_id = ? AND seed >= ? AND seed < ?"
        return {seed for (seed,) in self.query(statement, case_id, seeds.start, seeds.stop)}

    def add(
        self, case_id: int, rows: Sequence[AnyRow], program: str = "an unknown program"
    ) -> None:
        """Write the rows of a case in one transaction, and keep rows that are stored already.

        Raises:
            StoreError: another program has run episodes of the case, or writing failed.
        """
        if not rows:
            return
        columns, places = ", ".join(rows[0]._fields), ", ?" * len(rows[0])
        with self._transaction():
            statement = "SELECT settings, program FROM cases WHERE id = ?"
            [(settings, before)] = self.query(statement, case_id)
            if before not in (None, program):
                raise StoreError(
                    f"{self.path}: the episodes with {in_words(self._case(case_id, settings))} "
                    f"were run by {before}, and new ones would be run by {program}; write to "
                    "another file"
                )
            self._connection.execute(
                "UPDATE cases SET program = ? WHERE id = ?", (program, case_id)
            )
            self._connection.executemany(
                f"INSERT OR IGNORE INTO episodes (case_id, {columns}) VALUES (?{places})",
                [(case_id, *row) for row in rows],
            )

    def programs(self) -> dict[int, str]:
        """Return the program that has run the episodes of each case with episodes."""
        statement = "SELECT id, program FROM cases WHERE program IS NOT NULL"
        return {case_id: str(program) for case_id, program in self.query(statement)}

    def cases(self) -> dict[int, Case]:
        """Return all cases by their numbers.

        Raises:
            StoreError: no sweep can have written one of them.
        """
        found = self.query("SELECT id, settings FROM cases ORDER BY id")
        return {number: self._case(number, text) for number, text in found}

    def rows(self, case_id: int, kind: type[AnyRow] = Row) -> Iterator[AnyRow]:
        """Yield the row of each episode of a case, in the order of the seeds.

        Raises:
            StoreError: no sweep can have written one of the rows.
        """
        columns = ", ".join(kind._fields)
        statement = f"SELECT {columns} FROM episodes WHERE case_id = ? ORDER BY seed"
        for values in self.query(statement, case_id):
            row = kind._make(values)
            if not is_whole(row):
                raise StoreError(
                    f"{self.path}: the row of case {case_id}, seed {row.seed!r} is damaged"
                )
            yield row

    def query(self, statement: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        """Yield the rows that a statement selects."""
        with self._errors_reported():
            # Not the cursor itself, which would fail if it is half read when the file is closed.
            yield from map(tuple, self._connection.execute(statement, values))

    def _case(self, number: int, text: str) -> Case:
        """Return the case in a text, or raise ``StoreError`` if ``key_of`` has not written it."""
        try:
            return read_case(text)
        except (ValueError, TypeError) as error:
            raise StoreError(f"{self.path}: case {number} is invalid: {error}") from error

    def _prepare(self, *, read_only: bool) -> None:
        """Create the tables in an empty file, and check any other file."""
        # In one transaction, because another sweep may be creating the tables at this moment.
        with self._transaction("DEFERRED" if read_only else "IMMEDIATE"):
            schema = self.query("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")
            tables = [statement for (statement,) in schema]
            if not tables and read_only:
                raise StoreError(f"{self.path}: the file has no results")
            for statement in TABLES if not tables else ():
                self._connection.execute(statement)
        if tables not in ([], TABLES):
            raise StoreError(f"{self.path}: it was not written by a sweep of this version")
        # Reading a damaged file might never end, and writing to it would do more damage.
        if [state for (state,) in self.query("PRAGMA quick_check(1)")] != ["ok"]:
            raise StoreError(f"{self.path}: the file is damaged")
        self._connection.execute(f"PRAGMA query_only = {read_only}")
        self._connection.execute("PRAGMA synchronous = FULL")

    @contextmanager
    def _transaction(self, kind: str = "IMMEDIATE") -> Iterator[None]:
        with self._errors_reported():
            self._connection.execute(f"BEGIN {kind}")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                # If the disk was full, the transaction has already ended.
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")
                raise

    @contextmanager
    def _errors_reported(self) -> Iterator[None]:
        """Turn errors of SQLite into a ``StoreError`` that names the file."""
        try:
            yield
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter for a damaged schema
            raise StoreError(f"{self.path}: {error}") from error
