"""The tables of a file of results.

A file may come from a stranger: views, triggers and other tables are not run but refused.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

from agents.errors import StoreError
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from warehouse_core.world.layout import MAX_CELLS

APPLICATION, VERSION = 0x57617265, 3
"""``application_id`` and ``user_version`` of a file of results."""

TABLE_OF: dict[type[AnyRow], str] = {Row: "episodes", FleetRow: "shifts"}
"""Table that has the rows of each kind."""

BOTH = " UNION ALL ".join(
    f"SELECT case_id, seed, program_id FROM {table}" for table in TABLE_OF.values()
)
"""Query that finds the rows of both kinds."""

MAX_REAL = 1e30
"""Limit on the absolute value of a number of a row."""

TOO_LARGE = f"ifnull(abs({{0}}), 0) > {MAX_REAL}"

COLUMN = {
    int: ("INTEGER NOT NULL", "typeof({0}) != 'integer'"),
    int | None: ("INTEGER", "typeof({0}) NOT IN ('integer', 'null')"),
    float: ("REAL NOT NULL", f"typeof({{0}}) != 'real' OR {TOO_LARGE}"),
    float | None: ("REAL", f"typeof({{0}}) NOT IN ('real', 'null') OR {TOO_LARGE}"),
    str: ("TEXT NOT NULL", "FALSE"),
}
"""Column of SQLite for each type of a field, and the condition that its value is damaged."""


def _create(kind: type[AnyRow], program: str) -> str:
    """Return the statement that creates a table; ``program`` constrains its last column."""
    types = get_type_hints(kind)
    columns = ", ".join(f"{name} {COLUMN[types[name]][0]}" for name in kind._fields)
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
"""Statements that make the tables of an empty file.

``writers`` has the programs of the episodes of each case, so that nobody has to look for them among
millions of episodes. The default of a program is never used; the files that exist have it.
"""

MAX_CASES = 50_000

MAX_LENGTH = 4 * MAX_CELLS
"""Bytes of a text at most: a case with a column of ``MAX_CELLS``, each a row of its own."""

MAX_NAMED = 20
"""Programs that are named at most."""

PROGRAM = "CAST(substr(name, 1, 1000) AS TEXT)"
"""Name of a program in a query; a hostile file may have a long one, or one that is no text."""

MAX_SCHEMA_STEPS = 1_000_000
"""Steps of SQLite's machine for reading the schema at most; a hostile schema may have no end."""

BELOW_ZERO = {"battery_left"}
"""Whole numbers of a row that may be below 0."""


def _damaged(kind: type[AnyRow]) -> str:
    """Return the query that finds a row that no sweep has written."""
    types = get_type_hints(kind)
    wrong = [f"mode NOT IN {MODES_OF[kind]}", "case_id NOT IN (SELECT id FROM cases)"]
    for name in kind._fields:
        wrong.append(COLUMN[types[name]][1].format(name))
        if types[name] is int and name not in BELOW_ZERO:
            wrong.append(f"{name} < 0")
    return f"SELECT case_id, seed FROM {TABLE_OF[kind]} WHERE {' OR '.join(wrong)} LIMIT 1"


DAMAGED = {kind: _damaged(kind) for kind in TABLE_OF}


def has_tables(connection: sqlite3.Connection, path: Path) -> bool:
    """Return whether a file has the tables; without them it is empty.

    The connection is in a transaction. Other tables and damaged ones are errors with the path.
    """
    connection.set_progress_handler(lambda: 1, MAX_SCHEMA_STEPS)
    try:
        [(owner, version)] = connection.execute(
            "SELECT application_id, user_version FROM pragma_application_id, pragma_user_version"
        )
        schema = _schema_of(connection)
    except sqlite3.OperationalError as error:
        # Errors that Python itself raises lack the attribute, such as for text that is not UTF-8.
        if getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_INTERRUPT:
            raise StoreError(f"{path}: its schema has no end") from error
        raise
    finally:
        connection.set_progress_handler(None, 0)
    if not schema:
        return False
    if owner != APPLICATION:
        raise StoreError(f"{path}: it is a database without results of a sweep")
    if version != VERSION:
        raise StoreError(f"{path}: its version is {version}; only {VERSION} can be read")
    if schema != _schema():
        raise StoreError(f"{path}: it was not written by a sweep")
    # A damaged file might be read for ever, and writing to it would do more damage.
    [(state,)] = connection.execute("PRAGMA quick_check(1)")
    if state != "ok":
        raise StoreError(f"{path}: it is damaged: {state}")
    return True


@cache
def _schema() -> list[list[list[str]]]:
    """Return the schema of ``TABLES``."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(TABLES)
        return _schema_of(connection)


def _schema_of(connection: sqlite3.Connection) -> list[Any]:
    """Return all tables and whatever else there is, with the words of their statements."""
    rows = connection.execute("SELECT name, type, tbl_name, sql FROM sqlite_master ORDER BY name")
    return [[str(each).split() for each in row] for row in rows]
