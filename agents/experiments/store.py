"""The results of an experiment: one SQLite file with a row for each episode.

Rows are written as episodes finish, and stay whatever happens to the program or the machine: every
batch of rows is one transaction, and it is on the disk before the next begins. The key of a row is
its case and its seed, so that no episode is stored twice.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any, NamedTuple

from agents.console.place import Stations
from agents.errors import StoreError
from agents.experiments.case import IMPLIED, TILES, Case, key_of

VERSION = 1
"""Of the tables; stored in the file as its ``user_version``."""

APPLICATION = 0x57617265
"""The ``application_id`` of these files."""

TIMEOUT, BUSY_SECONDS = 30.0, 0.1
"""Seconds to wait for another program that writes to the same file, and between two checks."""

TABLES = f"""
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
PRAGMA application_id = {APPLICATION};
PRAGMA user_version = {VERSION};
"""


class Row(NamedTuple):
    """One episode.

    Attributes:
        seed: of layout, start and agent.
        mode: its outcome, see ``warehouse_core/records/failure_modes.py``.
        steps: its length.
        needed: the fewest steps to the delivery; ``None`` if there is no way.
        reward: the total.
        battery_left: units, at the end.
        seconds: of simulated time.
        joules: of energy.
        row: of the cell where the robot ended or was stuck.
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
    """A file of results, created if there is none. It is a context manager.

    Args:
        path: of the file.
        read_only: create no file and write to none; one without write permission can be read.
        check: is called while another program holds a lock; what it raises ends the wait.

    Raises:
        StoreError: it cannot be opened, or is something else.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        read_only: bool = False,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.path, self._check = Path(path), check
        if read_only and not self.path.is_file():
            raise StoreError(f"{path}: there is no such file")
        if self.path.exists() and not self.path.is_file():  # SQLite would try, and leave a journal
            raise StoreError(f"{path}: it is a folder or a device, not a file")
        with self._errors_reported():
            closed, path = self._is_closed(), self.path.absolute()
            address = f"{path.as_uri()}?immutable=1" if closed else path
            self._connection = sqlite3.connect(
                address, timeout=BUSY_SECONDS, isolation_level=None, uri=closed
            )
            try:
                self._prepare(read_only)
            except BaseException:
                self._connection.close()
                raise
        self._identity = _identity(self.path)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def case_id(self, case: Case) -> int:
        """Return the number of a case, which is added if it is new."""
        self.add_cases([case])
        return int(next(self.query("SELECT id FROM cases WHERE settings = ?", key_of(case)))[0])

    def add_cases(self, cases: Iterable[Case]) -> None:
        """Add the cases that are new, in one transaction."""
        with self._transaction():
            self._connection.executemany(
                "INSERT OR IGNORE INTO cases (settings) VALUES (?)",
                [(key_of(case),) for case in cases],
            )

    def count(self, case: Case, seeds: range) -> int:
        """Return how many episodes of a case with these seeds are stored."""
        statement = (
            "SELECT count(*) FROM episodes JOIN cases ON id = case_id "
            "WHERE settings = ? AND seed >= ? AND seed < ?"
        )
        return int(next(self.query(statement, key_of(case), seeds.start, seeds.stop))[0])

    def seeds_done(self, case_id: int, seeds: range) -> set[int]:
        """Return those of some seeds whose episodes are stored."""
        statement = "SELECT seed FROM episodes WHERE case_id = ? AND seed >= ? AND seed < ?"
        return {seed for (seed,) in self.query(statement, case_id, seeds.start, seeds.stop)}

    def add(self, case_id: int, rows: Sequence[Row]) -> None:
        """Write the episodes of a case, all or none; those that are stored already stay unchanged.

        Raises:
            StoreError: the disk is full, or the file cannot be written or is no longer there.
        """
        # SQLite would continue to write to a file that has been removed.
        if _identity(self.path) != self._identity:
            raise StoreError(f"{self.path}: it has been removed or replaced meanwhile")
        places = ", ".join("?" * (1 + len(Row._fields)))
        with self._transaction():
            self._connection.executemany(
                f"INSERT OR IGNORE INTO episodes VALUES ({places})",
                [(case_id, *row) for row in rows],
            )

    def cases(self) -> dict[int, Case]:
        """Return every case by its number.

        Raises:
            StoreError: a case that no sweep has written.
        """
        found = list(self.query("SELECT id, settings FROM cases ORDER BY id"))
        return {number: self._case(settings) for number, settings in found}

    def rows(self, case_id: int) -> Iterator[Row]:
        """Yield the episodes of a case in the order of their seeds."""
        names = ", ".join(Row._fields)
        statement = f"SELECT {names} FROM episodes WHERE case_id = ? ORDER BY seed"
        return map(Row._make, self.query(statement, case_id))

    def query(self, statement: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        """Yield the rows that a statement finds."""
        with self._errors_reported():
            # Not the cursor itself: left half read, it would fail when the file is closed.
            yield from map(tuple, self._execute(statement, *values))

    def _case(self, text: str) -> Case:
        """Return a case that ``key_of`` has written, and raise for any other text."""
        try:
            case = json.loads(text)
            if isinstance(case, dict) and _is_case(case):
                return IMPLIED | case
        except (ValueError, TypeError, RecursionError):
            pass
        raise StoreError(f"{self.path}: it has an invalid case, {text!r}")

    def _is_closed(self) -> bool:
        """Return whether the file can only be read, and its folder does not allow new files.

        Even for reading SQLite creates files beside it, unless the file is opened as immutable.

        Raises:
            StoreError: another program writes to it, or was stopped while writing.
        """
        if not self.path.is_file() or all(
            os.access(each, os.W_OK) for each in (self.path, self.path.parent)
        ):
            return False
        log = Path(f"{self.path}-wal")
        if log.is_file() and log.stat().st_size:
            raise StoreError(
                f"{self.path}: it is read-only here, and its newest rows are still in {log.name}; "
                "read it where it can be written, or after the sweep has ended"
            )
        return True

    def _prepare(self, read_only: bool) -> None:
        connection = self._connection
        # In one transaction: another sweep may be creating the tables at this moment.
        with self._transaction("DEFERRED" if read_only else "IMMEDIATE"):
            is_new = self._is_empty()
            if is_new and not read_only:
                for statement in TABLES.split(";"):
                    connection.execute(statement)
        if read_only:
            if is_new:
                raise StoreError(f"{self.path}: there are no results in it")
            connection.execute("PRAGMA query_only = ON")
            # One view of the file, whatever a sweep adds meanwhile.
            connection.execute("BEGIN")
            return
        # Others can then read meanwhile.
        self._execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")

    def _is_empty(self) -> bool:
        """Return whether there are no tables, and raise if there are those of another program."""
        [(owner, version, tables)] = self._execute(
            "SELECT application_id, user_version, (SELECT count(*) FROM sqlite_master) "
            "FROM pragma_application_id, pragma_user_version"
        )
        if tables and owner != APPLICATION:
            raise StoreError(f"{self.path}: it is a database, but not of results")
        if tables and version != VERSION:
            raise StoreError(f"{self.path}: its version is {version}; only {VERSION} can be read")
        return not tables

    def _execute(self, statement: str, *values: Any) -> sqlite3.Cursor:
        """Execute a statement, and wait while another program holds a lock."""
        end = monotonic() + TIMEOUT
        while True:
            try:
                return self._connection.execute(statement, values)
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or monotonic() > end:
                    raise
                self._check()
                sleep(0.01)  # for some statements SQLite itself does not wait

    @contextmanager
    def _transaction(self, kind: str = "IMMEDIATE") -> Iterator[None]:
        with self._errors_reported():
            self._execute(f"BEGIN {kind}")
            try:
                yield
                self._execute("COMMIT")
            except BaseException:
                # A full disk has ended the transaction already.
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")
                raise

    @contextmanager
    def _errors_reported(self) -> Iterator[None]:
        """Turn errors of SQLite into a ``StoreError`` with the name of the file."""
        try:
            yield
        except sqlite3.Error as error:
            raise StoreError(f"{self.path}: {error}") from error


def _identity(path: Path) -> tuple[int, int] | None:
    """Return what distinguishes a file from one that has replaced it."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return found.st_dev, found.st_ino


def _is_case(case: dict[str, object]) -> bool:
    """Return whether a case has everything that other modules rely on."""
    rows = case.get(TILES, ["#"])
    names = ("agent", "layout", "backend")
    return (
        all(map(_is_parameter, case, case.values()))
        and all(isinstance(case.get(name), str) for name in names)
        and isinstance(rows, list)
        and len(set(map(len, rows))) == 1
        and case.get("stations", Stations.DRAWN) in list(Stations)
    )


def _is_parameter(name: str, value: object) -> bool:
    if name == TILES:
        return isinstance(value, list) and all(isinstance(row, str) for row in value)
    if name in Row._fields or not isinstance(value, (str, int, float)):
        return False
    return not isinstance(value, int) or abs(value) < 2**63
