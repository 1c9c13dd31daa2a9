"""The tables of a file of results, in each version, and whether a file has them and nothing else.

A file may come from a stranger: views, triggers and other tables are not run but refused.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

from agents.errors import StoreError
from warehouse_core.records.failure_modes import MODES
from warehouse_core.world.layout import MAX_CELLS

APPLICATION = 0x57617265
"""The ``application_id`` of these files."""

UNKNOWN = "an unknown program"
"""Of episodes that were stored before the tables had programs."""

TABLES = (
    f"""
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
PRAGMA user_version = 1;
""",
    f"""
CREATE TABLE programs (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);
INSERT INTO programs VALUES (0, '{UNKNOWN}');
ALTER TABLE episodes ADD COLUMN program_id INTEGER NOT NULL DEFAULT 0 REFERENCES programs;
CREATE TABLE writers (
    case_id INTEGER NOT NULL REFERENCES cases,
    program_id INTEGER NOT NULL REFERENCES programs,
    PRIMARY KEY (case_id, program_id)
) WITHOUT ROWID;
INSERT INTO writers
SELECT id, 0 FROM cases WHERE EXISTS (SELECT 1 FROM episodes WHERE case_id = id);
PRAGMA user_version = 2;
""",
)
"""The first version of the tables, and the change that makes each further one of the one before.

``writers`` has the programs of the episodes of each case, which are not looked for among millions.
"""

VERSION = len(TABLES)
"""Of the tables; stored in the file as its ``user_version``. All before it can be read."""

MAX_CASES = 50_000

MAX_LENGTH = 4 * MAX_CELLS
"""Of a text in bytes: a case with a column of ``MAX_CELLS``, each a row of its own."""

MAX_NAMED = 20
"""Programs that are named."""

PROGRAM = "CAST(substr(name, 1, 1000) AS TEXT)"
"""The name of a program, which in a hostile file may be long or no text."""

MAX_SCHEMA_STEPS = 1_000_000
"""Of SQLite's machine, for reading the schema; that of a hostile file may have no end."""

MAX_REAL = 1e30
"""Of the numbers of a row."""

WHOLE, REAL = ("seed", "steps", "row", "col"), ("reward", "seconds", "joules")

WRONG = (
    *(f"typeof({name}) != 'integer' OR {name} < 0" for name in WHOLE),
    *(f"typeof({name}) != 'real' OR abs({name}) > {MAX_REAL}" for name in REAL),
    "typeof(battery_left) != 'integer'",
    "typeof(needed) NOT IN ('integer', 'null')",
    f"mode NOT IN {MODES}",
    "case_id NOT IN (SELECT id FROM cases)",
)

DAMAGED = f"SELECT case_id, seed FROM episodes WHERE {' OR '.join(WRONG)} LIMIT 1"
"""Finds a row that no sweep has written."""


def version_of(connection: sqlite3.Connection, path: Path) -> int:
    """Return the version of the tables in a file, 0 if it is empty.

    Args:
        connection: in a transaction.
        path: of the file, for messages.

    Raises:
        StoreError: there are other tables, or they are damaged.
    """
    connection.set_progress_handler(lambda: 1, MAX_SCHEMA_STEPS)
    try:
        [(owner, version)] = connection.execute(
            "SELECT application_id, user_version FROM pragma_application_id, pragma_user_version"
        )
        schema = _schema_of(connection)
    except sqlite3.OperationalError as error:
        # The attribute is missing where Python itself raises, as of text that is not UTF-8.
        if getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_INTERRUPT:
            raise StoreError(f"{path}: its schema has no end") from error
        raise
    finally:
        connection.set_progress_handler(None, 0)
    if not schema:
        return 0
    if owner != APPLICATION:
        raise StoreError(f"{path}: it is a database, but not of results")
    if not 1 <= version <= VERSION:
        raise StoreError(f"{path}: its version is {version}; only 1 to {VERSION} can be read")
    if schema != _schema(version):
        raise StoreError(f"{path}: its tables are not those of a sweep")
    # A damaged file might be read for ever, and writing to it would do more damage.
    [(found,)] = connection.execute("PRAGMA quick_check(1)")
    if found != "ok":
        raise StoreError(f"{path}: it is damaged: {found}")
    return int(version)


@cache
def _schema(version: int) -> list[tuple[Any, ...]]:
    """Return the schema of a version of the tables."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript("".join(TABLES[:version]))
        return _schema_of(connection)


def _schema_of(connection: sqlite3.Connection) -> list[tuple[Any, ...]]:
    """Return all tables and whatever else there is, with the statements that make them."""
    found = connection.execute("SELECT name, type, tbl_name, sql FROM sqlite_master ORDER BY name")
    return [tuple(str(each).split() for each in row) for row in found]
