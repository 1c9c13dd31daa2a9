"""The results of an experiment: one SQLite file, a row an episode, written as episodes finish.

What is written stays, whatever happens to the program or the machine: every batch of rows is one
transaction, and it is on the disk before the next begins. A row has its case and its seed for a
key, so that no episode is in it twice.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from agents.experiments.case import Case, key_of

VERSION = 1
"""Of the tables; kept in the file as its ``user_version``."""

APPLICATION = 0x57617265
"""Says whose file it is, as its ``application_id``."""

TABLES = """
CREATE TABLE cases (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE);
CREATE TABLE episodes (
    case_id INTEGER NOT NULL REFERENCES cases,
    seed INTEGER NOT NULL,
    mode TEXT NOT NULL,
    steps INTEGER NOT NULL,
    needed INTEGER,
    reward REAL NOT NULL,
    battery_left INTEGER NOT NULL,
    seconds REAL NOT NULL,
    joules REAL NOT NULL,
    row INTEGER NOT NULL,
    col INTEGER NOT NULL,
    PRIMARY KEY (case_id, seed)
) WITHOUT ROWID;
"""


class StoreError(Exception):
    """A file of results that cannot be used or written; the message says which and why."""


class Row(NamedTuple):
    """One episode.

    Attributes:
        seed: of layout, start and agent.
        mode: what became of it, see ``failure_modes.py``.
        steps: its length.
        needed: the fewest steps there are to the delivery; ``None`` where no way leads there.
        reward: the sum of all.
        battery_left: units, at the end.
        seconds: of simulated time.
        joules: of energy.
        row: of the cell where it ended or was stuck.
        col: of that cell.
    """

    seed: int
    mode: str
    steps: int
    needed: int | None
    reward: float
    battery_left: int
    seconds: float
    joules: float
    row: int
    col: int


class Store:
    """A file of results, made if there is none. It is a context manager.

    Args:
        path: of the file.
        read_only: make no file and write to none; one that may not be written can be read.

    Raises:
        StoreError: it cannot be opened, or is something else.
    """

    def __init__(self, path: str | Path, *, read_only: bool = False) -> None:
        self.path = Path(path)
        if read_only and not self.path.is_file():
            raise StoreError(f"{path}: there is no such file")
        with self._told():
            self._connection = sqlite3.connect(self._address(), isolation_level=None, uri=True)
            try:
                self._prepare(read_only)
            except BaseException:
                self._connection.close()
                raise

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def case_id(self, case: Case) -> int:
        """Return the number of a case, which it gets here if it is new."""
        with self._told():
            self._connection.execute(
                "INSERT OR IGNORE INTO cases (settings) VALUES (?)", (key_of(case),)
            )
            found = self._connection.execute(
                "SELECT id FROM cases WHERE settings = ?", (key_of(case),)
            )
            number: int = found.fetchone()[0]
        return number

    def count(self, case: Case, seeds: range) -> int:
        """Return how many episodes of a case with these seeds are there."""
        statement = (
            "SELECT count(*) FROM episodes JOIN cases ON id = case_id "
            "WHERE settings = ? AND seed >= ? AND seed < ?"
        )
        found: int = next(self.query(statement, key_of(case), seeds.start, seeds.stop))[0]
        return found

    def seeds_done(self, case_id: int) -> set[int]:
        """Return the seeds of a case whose episodes are there."""
        return {
            seed for (seed,) in self.query("SELECT seed FROM episodes WHERE case_id = ?", case_id)
        }

    def add(self, case_id: int, rows: Sequence[Row]) -> None:
        """Write the episodes of a case, all or none; those that are there already stay as they are.

        Raises:
            StoreError: the disk is full, or the file cannot be written.
        """
        places = ", ".join("?" * (1 + len(Row._fields)))
        with self._told(), self._transaction():
            self._connection.executemany(
                f"INSERT OR IGNORE INTO episodes VALUES ({places})",
                [(case_id, *row) for row in rows],
            )

    def cases(self) -> dict[int, Case]:
        """Return every case by its number."""
        found = self.query("SELECT id, settings FROM cases ORDER BY id")
        return {number: json.loads(settings) for number, settings in found}

    def rows(self, case_id: int) -> Iterator[Row]:
        """Yield the episodes of a case in the order of their seeds."""
        names = ", ".join(Row._fields)
        statement = f"SELECT {names} FROM episodes WHERE case_id = ? ORDER BY seed"
        return map(Row._make, self.query(statement, case_id))

    def query(self, statement: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        """Yield the rows that a statement finds."""
        with self._told():
            yield from self._connection.execute(statement, values)

    def _address(self) -> str:
        """Return the file as SQLite's URI."""
        # Even to read it, SQLite makes files beside it, unless it is told that nobody writes.
        is_closed = self.path.is_file() and not all(
            os.access(each, os.W_OK) for each in (self.path, self.path.parent)
        )
        return self.path.absolute().as_uri() + ("?immutable=1" if is_closed else "")

    def _prepare(self, read_only: bool) -> None:
        connection = self._connection
        owner, version, tables = (
            connection.execute(question).fetchone()[0]
            for question in (
                "PRAGMA application_id",
                "PRAGMA user_version",
                "SELECT count(*) FROM sqlite_master",
            )
        )
        if tables and owner != APPLICATION:
            raise StoreError(f"{self.path}: it is a database, but not of results")
        if tables and version != VERSION:
            raise StoreError(f"{self.path}: its version is {version}; {VERSION} can be read")
        if read_only:
            if not tables:
                raise StoreError(f"{self.path}: there are no results in it")
            connection.execute("PRAGMA query_only = ON")
            return
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        if not tables:
            with self._transaction():
                for statement in TABLES.split(";"):
                    connection.execute(statement)
                connection.execute(f"PRAGMA application_id = {APPLICATION}")
                connection.execute(f"PRAGMA user_version = {VERSION}")

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            # A full disk has ended the transaction already.
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")
            raise
        self._connection.execute("COMMIT")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Turn what SQLite raises into one line with the name of the file."""
        try:
            yield
        except sqlite3.Error as error:
            raise StoreError(f"{self.path}: {error}") from error
