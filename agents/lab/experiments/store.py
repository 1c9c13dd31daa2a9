"""The results of an experiment: one SQLite file with a row for each episode.

Rows are written as episodes finish, and survive whatever happens to the program or the machine.
Every batch of rows is one transaction, which is on the disk before the next one begins. The key of
a row is its case and its seed, so that no episode is stored twice.

A file may come from a stranger. Files with views, triggers or other tables are therefore refused.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from time import monotonic, sleep
from typing import Any, get_args, get_type_hints

from agents.errors import StoreError
from agents.lab.experiments.case import (
    MAX_LENGTH,
    TILES,
    Case,
    in_words,
    key_of,
    read_case,
    row_type,
)
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from warehouse_core.files.reading import not_a_file

TIMEOUT = 30.0
"""Seconds to wait while another program writes to the same file."""

UNKNOWN = "an unknown program"
"""Name shown for the program of a row if the file does not name it."""

APPLICATION, VERSION = 0x57617265, 3
"""``application_id`` and ``user_version`` of a file of results."""

TABLE_OF: dict[type[AnyRow], str] = {Row: "episodes", FleetRow: "shifts"}
"""Table that contains the rows of each type."""

BOTH = " UNION ALL ".join(
    f"SELECT case_id, seed, program_id FROM {table}" for table in TABLE_OF.values()
)
"""Query for the rows of both types."""

MAX_REAL = 1e30
"""Maximum absolute value of a real number in a row."""

COLUMN = {
    int: "INTEGER NOT NULL", int | None: "INTEGER", float: "REAL NOT NULL", float | None: "REAL",
    str: "TEXT NOT NULL",
}  # fmt: skip
"""SQLite column for each type of a field."""


def _create(kind: type[AnyRow], program: str) -> str:
    """Return the statement that creates a table; ``program`` constrains its last column."""
    types = get_type_hints(kind)
    columns = ", ".join(f"{name} {COLUMN[types[name]]}" for name in kind._fields)
    return (
        f"CREATE TABLE {TABLE_OF[kind]} ( case_id INTEGER NOT NULL REFERENCES cases, {columns}, "
        f"program_id INTEGER NOT NULL {program}, PRIMARY KEY (case_id, seed) ) WITHOUT ROWID"
    )


TABLES = f"""
CREATE TABLE cases (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE);
CREATE TABLE programs (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);
CREATE TABLE writers (
    case_id INTEGER NOT NULL REFERENCES cases,
    program_id INTEGER NOT NULL REFERENCES programs,
    PRIMARY KEY (case_id, program_id)
) WITHOUT ROWID;
{_create(Row, "DEFAULT 0 REFERENCES programs")};
{_create(FleetRow, "REFERENCES programs")};
PRAGMA application_id = {APPLICATION};
PRAGMA user_version = {VERSION};
"""
"""Statements that create the tables in an empty file.

``writers`` lists the programs that wrote episodes of each case, so that they need not be searched
for among millions of episodes. The default value of ``program_id`` is never used; it is there
because existing files have it.
"""

MAX_CASES = 50_000

MAX_NAMED = 20
"""Maximum number of programs that are named."""

PROGRAM = "CAST(substr(name, 1, 1000) AS TEXT)"
"""SQL expression for the name of a program, which may be very long or no text in a hostile file."""

BELOW_ZERO = {"battery_left"}
"""Integer fields of a row that may be negative."""

FIELDS = {
    kind: [get_args(each) or (each,) for each in get_type_hints(kind).values()] for kind in TABLE_OF
}
"""Types that each field of a row may have."""


def is_whole(row: AnyRow) -> bool:
    """Return whether a sweep can have written a row; reports rely on it."""
    if row.mode not in MODES_OF[type(row)]:
        return False
    for name, value, types in zip(row._fields, row, FIELDS[type(row)], strict=True):
        if type(value) not in types or (type(value) is float and abs(value) > MAX_REAL):
            return False
        if type(value) is int and value < 0 and name not in BELOW_ZERO:
            return False
    return True


class Store:
    """A file of results, which is created if it does not exist; a context manager.

    Every failure, such as a damaged file or a full disk, raises a ``StoreError`` that names the
    file.

    Args:
        path: Path of the file.
        read_only: Do not create or change the file. It needs no write permission then.
    """

    def __init__(self, path: str | Path, *, read_only: bool = False) -> None:
        self.path, self._read_only = Path(path), read_only
        if (kind := not_a_file(self.path)) is not None:  # SQLite would try, and leave a journal
            raise StoreError(f"{path}: {kind}")
        if read_only and not self.path.exists():
            raise StoreError(f"{path}: there is no such file")
        with self._errors_reported():
            closed, path = self._is_closed(), self.path.absolute()
            address = f"{path.as_uri()}?immutable=1" if closed else path
            self._connection = sqlite3.connect(
                address, timeout=TIMEOUT, isolation_level=None, uri=closed
            )
            self._connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_LENGTH)
            try:
                self._prepare()
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
        """Return the number of a case, after adding the case if it is new."""
        self.add_cases([case])
        return int(next(self.query("SELECT id FROM cases WHERE settings = ?", key_of(case)))[0])

    def add_cases(self, cases: Iterable[Case]) -> None:
        """Add the new ones among some cases, in one transaction."""
        with self._transaction():
            self._connection.executemany(
                "INSERT OR IGNORE INTO cases (settings) VALUES (?)",
                [(key_of(case),) for case in cases],
            )
            self._check_count()

    def count(self, case: Case, seeds: range) -> int:
        """Return the number of stored episodes of a case with the given seeds."""
        statement = (
            f"SELECT count(*) FROM {TABLE_OF[row_type(case)]} JOIN cases ON id = case_id "
            "WHERE settings = ? AND seed >= ? AND seed < ?"
        )
        return int(next(self.query(statement, key_of(case), seeds.start, seeds.stop))[0])

    def seeds_done(self, case_id: int, seeds: range) -> set[int]:
        """Return the seeds, among the given ones, whose episodes of a case are stored."""
        statement = f"SELECT seed FROM ({BOTH}) WHERE case_id = ? AND seed >= ? AND seed < ?"
        return {seed for (seed,) in self.query(statement, case_id, seeds.start, seeds.stop)}

    def add(self, case_id: int, rows: Sequence[AnyRow], program: str = UNKNOWN) -> None:
        """Write the rows of a case in one transaction, and keep rows that are stored already.

        Raises:
            StoreError: another program has written episodes of the case, or writing failed.
        """
        # SQLite would continue to write to a file that has been removed.
        if _identity(self.path) != self._identity:
            raise StoreError(f"{self.path}: the file has been removed or replaced meanwhile")
        if not rows:
            return
        places = ", ".join("?" * (2 + len(rows[0])))
        table = TABLE_OF[type(rows[0])]
        with self._transaction():
            number = self._add_writer(case_id, program)
            self._connection.executemany(
                f"INSERT OR IGNORE INTO {table} VALUES ({places})",
                [(case_id, *row, number) for row in rows],
            )

    def _add_writer(self, case_id: int, program: str) -> int:
        """Register a program as the writer of a case's episodes, and return its number."""
        writers = self.query(
            f"SELECT {PROGRAM} FROM writers JOIN programs ON id = program_id "
            f"WHERE case_id = ? ORDER BY id LIMIT {MAX_NAMED}", case_id,
        )  # fmt: skip
        if others := [name for (name,) in writers if name != program]:
            [(text,)] = self.query("SELECT settings FROM cases WHERE id = ?", case_id)
            settings = in_words(self._case(case_id, text))
            raise StoreError(
                f"{self.path}: the episodes with {settings} were run by {' and '.join(others)}, "
                f"and new ones would be run by {program}; write to another file"
            )
        self._connection.execute("INSERT OR IGNORE INTO programs (name) VALUES (?)", (program,))
        [(number,)] = self.query("SELECT id FROM programs WHERE name = ?", program)
        self._connection.execute("INSERT OR IGNORE INTO writers VALUES (?, ?)", (case_id, number))
        return int(number)

    def episodes(self) -> list[tuple[str, int]]:
        """Return each program and its number of episodes, in descending order of this number."""
        statement = (
            f"SELECT (SELECT {PROGRAM} FROM programs WHERE id = program_id), count(*) AS number "
            f"FROM ({BOTH}) GROUP BY program_id ORDER BY number DESC LIMIT {MAX_NAMED}"
        )
        return [(name or UNKNOWN, count) for name, count in self.query(statement)]

    def cases(self) -> dict[int, Case]:
        """Return all cases by their numbers.

        Raises:
            StoreError: no sweep can have written one of them.
        """
        self._check_count()
        cases, layouts = dict[int, Case](), dict[tuple[str, ...], list[str]]()
        for number, text in self.query("SELECT id, settings FROM cases ORDER BY id"):
            case = self._case(number, text)
            if TILES in case:  # equal layouts share one list, because they may be large
                case = {**case, TILES: layouts.setdefault(tuple(case[TILES]), case[TILES])}
            cases[number] = case
        return cases

    def rows(self, case_id: int, kind: type[AnyRow] = Row) -> Iterator[tuple[AnyRow, str]]:
        """Yield the row and the program of each episode of a case, in the order of the seeds.

        Raises:
            StoreError: no sweep can have written one of the rows.
        """
        statement = (
            f"SELECT {', '.join(kind._fields)}, "
            f"(SELECT {PROGRAM} FROM programs WHERE id = program_id) "
            f"FROM {TABLE_OF[kind]} WHERE case_id = ? ORDER BY seed"
        )
        for found in self.query(statement, case_id):
            row = kind._make(found[:-1])
            if not is_whole(row):
                raise StoreError(
                    f"{self.path}: the row of case {case_id}, seed {row.seed!r} is damaged"
                )
            yield row, found[-1] or UNKNOWN

    def query(self, statement: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        """Yield the rows that a statement selects."""
        with self._errors_reported():
            # Not the cursor itself, which would fail if it is half read when the file is closed.
            yield from map(tuple, self._connection.execute(statement, values))

    def _case(self, number: int, text: str) -> Case:
        """Return the case in a text, or raise ``StoreError`` if ``key_of`` has not written it."""
        try:
            return read_case(text)
        except (ValueError, TypeError, RecursionError) as error:
            raise StoreError(f"{self.path}: case {number} is invalid: {error}") from error

    def _check_count(self) -> None:
        [(count,)] = self.query("SELECT count(*) FROM cases")
        if count > MAX_CASES:
            raise StoreError(
                f"{self.path}: it has {count} cases; at most MAX_CASES = {MAX_CASES} are allowed"
            )

    def _is_closed(self) -> bool:
        """Return whether the file or its folder is read-only. It is then opened as immutable.

        Otherwise SQLite creates files next to it even for reading.

        Raises:
            StoreError: the newest rows are still in the log, which could not be read.
        """
        if not self.path.is_file() or all(
            os.access(each, os.W_OK) for each in (self.path, self.path.parent)
        ):
            return False
        log = Path(f"{self.path}-wal")
        if log.is_file() and log.stat().st_size:
            raise StoreError(
                f"{self.path}: the file is read-only, and its newest rows are still in {log.name}; "
                "read it where it can be written, or after the sweep has ended"
            )
        return True

    def _prepare(self) -> None:
        connection, read_only = self._connection, self._read_only
        # In one transaction, because another sweep may be creating the tables at this moment.
        with self._transaction("DEFERRED" if read_only else "IMMEDIATE"):
            is_empty = not has_tables(connection, self.path)
            if is_empty and not read_only:
                for statement in TABLES.split(";"):
                    connection.execute(statement)
        if read_only:
            if is_empty:
                raise StoreError(f"{self.path}: the file has no results")
            connection.execute("PRAGMA query_only = ON")
            # The transaction keeps one view of the file, whatever a sweep adds meanwhile.
            connection.execute("BEGIN")
            return
        self._let_others_read()
        connection.execute("PRAGMA synchronous = FULL")

    def _let_others_read(self) -> None:
        """Let other programs read while this one writes.

        SQLite itself does not wait for another program before it changes the journal mode.
        """
        end = monotonic() + TIMEOUT
        while True:
            try:
                self._connection.execute("PRAGMA journal_mode = WAL")
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or monotonic() > end:
                    raise
                sleep(0.01)
            else:
                return

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


def _identity(path: Path) -> tuple[int, int] | None:
    """Return the device and inode of a file, which differ for a file that has replaced it."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return status.st_dev, status.st_ino


def has_tables(connection: sqlite3.Connection, path: Path) -> bool:
    """Return ``True`` if a file has the tables of results, and ``False`` if it is empty.

    The connection must be in a transaction.

    Raises:
        StoreError: the file has other tables, or is damaged.
    """
    [(owner, version)] = connection.execute(
        "SELECT application_id, user_version FROM pragma_application_id, pragma_user_version"
    )
    schema = _schema_of(connection)
    if not schema:
        return False
    if owner != APPLICATION:
        raise StoreError(f"{path}: this database does not have the results of a sweep")
    if version != VERSION:
        raise StoreError(f"{path}: its version is {version}; only version {VERSION} can be read")
    if schema != _schema():
        raise StoreError(f"{path}: it was not written by a sweep")
    # Reading a damaged file might never end, and writing to it would do more damage.
    [(state,)] = connection.execute("PRAGMA quick_check(1)")
    if state != "ok":
        raise StoreError(f"{path}: the file is damaged: {state}")
    return True


@cache
def _schema() -> list[list[list[str]]]:
    """Return the schema of ``TABLES``."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(TABLES)
        return _schema_of(connection)


def _schema_of(connection: sqlite3.Connection) -> list[Any]:
    """Return the name, type, table and statement of everything in the schema, split into words."""
    rows = connection.execute("SELECT name, type, tbl_name, sql FROM sqlite_master ORDER BY name")
    return [[str(each).split() for each in row] for row in rows]
