"""The rows and tables of a file of results, in each version.

``version_of`` tells whether a file has these tables and nothing else.

A file may come from a stranger: views, triggers and other tables are not run but refused.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

from agents.errors import StoreError
from warehouse_core.records.failure_modes import FLEET_MODES, MODES
from warehouse_core.world.layout import MAX_CELLS

APPLICATION = 0x57617265
"""The ``application_id`` of these files."""

UNKNOWN = "an unknown program"
"""Of episodes that were stored before the tables had programs."""


class Row(NamedTuple):
    """One episode of a lone robot.

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


class Shift(NamedTuple):
    """One episode of a fleet.

    Attributes:
        seed: of layout, starts, orders, people and agents.
        mode: its outcome, see ``warehouse_core/records/failure_modes.py``.

    The others are those of ``FleetMeasures``; ``None`` is where nothing was measured.
    """

    seed: int
    mode: str
    steps: int
    seconds: float
    orders: int
    delivered: int
    per_hour: float | None
    mean_lateness: float | None
    worst_lateness: float | None
    on_time: float | None
    joules: float
    joules_per_delivery: float | None
    blocked_by_wall: int
    blocked_by_robot: int
    blocked_by_person: int
    waits: int
    charging: int
    distance: int
    stranded: int


AnyRow = Row | Shift

TABLE_OF: dict[type[AnyRow], str] = {Row: "episodes", Shift: "shifts"}
"""The table that has the rows of each kind."""

BOTH = " UNION ALL ".join(
    f"SELECT case_id, seed, program_id FROM {table}" for table in TABLE_OF.values()
)
"""Finds the rows of both kinds."""

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
    """
CREATE TABLE shifts (
    case_id INTEGER NOT NULL REFERENCES cases,
    seed INTEGER NOT NULL,
    mode TEXT NOT NULL,
    steps INTEGER NOT NULL,
    seconds REAL NOT NULL,
    orders INTEGER NOT NULL,
    delivered INTEGER NOT NULL,
    per_hour REAL,
    mean_lateness REAL,
    worst_lateness REAL,
    on_time REAL,
    joules REAL NOT NULL,
    joules_per_delivery REAL,
    blocked_by_wall INTEGER NOT NULL,
    blocked_by_robot INTEGER NOT NULL,
    blocked_by_person INTEGER NOT NULL,
    waits INTEGER NOT NULL,
    charging INTEGER NOT NULL,
    distance INTEGER NOT NULL,
    stranded INTEGER NOT NULL,
    program_id INTEGER NOT NULL REFERENCES programs,
    PRIMARY KEY (case_id, seed)
) WITHOUT ROWID;
PRAGMA user_version = 3;
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


def _damaged(kind: type[AnyRow], modes: Sequence[str], *others: str) -> str:
    """Return the statement that finds a row that no sweep has written.

    Args:
        kind: of the row.
        modes: that it may have.
        others: conditions that only such a row meets, on columns that may be below 0 or be absent.
    """
    types, told = get_type_hints(kind), " ".join(others)
    wrong = [f"mode NOT IN {tuple(modes)}", "case_id NOT IN (SELECT id FROM cases)", *others]
    for name in kind._fields:
        if types[name] is int and name not in told:
            wrong.append(f"typeof({name}) != 'integer' OR {name} < 0")
        elif types[name] is float:
            wrong.append(f"typeof({name}) != 'real' OR abs({name}) > {MAX_REAL}")
        elif types[name] == float | None:
            wrong.append(
                f"typeof({name}) NOT IN ('real', 'null') OR ifnull(abs({name}), 0) > {MAX_REAL}"
            )
    return f"SELECT case_id, seed FROM {TABLE_OF[kind]} WHERE {' OR '.join(wrong)} LIMIT 1"


DAMAGED = {
    Row: _damaged(
        Row, MODES,
        "typeof(battery_left) != 'integer'", "typeof(needed) NOT IN ('integer', 'null')",
    ),
    Shift: _damaged(Shift, FLEET_MODES),
}  # fmt: skip


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
