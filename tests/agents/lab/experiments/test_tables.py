"""Files of results from strangers: only the tables of a sweep are read, and nothing else is run."""

from pathlib import Path

import pytest
from helpers.command_line import Refused
from helpers.results_files import change, fill, fleet_row, row

from agents.errors import StoreError
from agents.lab.experiments import tables
from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row

ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT"
COLUMNS = ", ".join(f"i AS {name}" for name in ("case_id", *Row._fields, "program_id"))
WRITTEN_BEFORE = """
CREATE TABLE cases (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE);
CREATE TABLE episodes (
    case_id INTEGER NOT NULL REFERENCES cases, seed INTEGER NOT NULL, mode TEXT NOT NULL,
    steps INTEGER NOT NULL, needed INTEGER, reward REAL NOT NULL, battery_left INTEGER NOT NULL,
    seconds REAL NOT NULL, joules REAL NOT NULL, row INTEGER NOT NULL,
    col INTEGER NOT NULL, program_id INTEGER NOT NULL DEFAULT 0 REFERENCES programs,
    PRIMARY KEY (case_id, seed)
) WITHOUT ROWID;
CREATE TABLE programs (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);
INSERT INTO programs VALUES (0, 'an unknown program');
CREATE TABLE writers (
    case_id INTEGER NOT NULL REFERENCES cases, program_id INTEGER NOT NULL REFERENCES programs,
    PRIMARY KEY (case_id, program_id)
) WITHOUT ROWID;
CREATE TABLE shifts (
    case_id INTEGER NOT NULL REFERENCES cases, seed INTEGER NOT NULL, mode TEXT NOT NULL,
    steps INTEGER NOT NULL, seconds REAL NOT NULL, orders INTEGER NOT NULL,
    delivered INTEGER NOT NULL, per_hour REAL, mean_lateness REAL, worst_lateness REAL,
    on_time REAL, joules REAL NOT NULL, joules_per_delivery REAL,
    blocked_by_wall INTEGER NOT NULL, blocked_by_robot INTEGER NOT NULL,
    blocked_by_person INTEGER NOT NULL, waits INTEGER NOT NULL, charging INTEGER NOT NULL,
    distance INTEGER NOT NULL, stranded INTEGER NOT NULL,
    program_id INTEGER NOT NULL REFERENCES programs, PRIMARY KEY (case_id, seed)
) WITHOUT ROWID;
PRAGMA application_id = 1466004069;
PRAGMA user_version = 3;
"""
ELSE = "it was not written by a sweep"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return fill(tmp_path / "r.sqlite", [({}, [row(0, needed=None)])])


def reason(path: Path) -> str:
    """Return the message, which is the same for reading and for resuming."""
    messages = set()
    for read_only in (True, False):
        with pytest.raises(StoreError) as caught:
            Store(path, read_only=read_only)
        messages.add(str(caught.value))
    [message] = messages
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    "script",
    [
        f"DROP TABLE episodes; CREATE VIEW episodes AS {ENDLESS} {COLUMNS} FROM n",
        f"DROP TABLE cases; CREATE VIEW cases AS {ENDLESS} i AS id, '' AS settings FROM n",
        "CREATE TRIGGER t AFTER INSERT ON cases BEGIN DELETE FROM episodes; END",
        f"CREATE VIEW more AS {ENDLESS} i FROM n",
        "CREATE TABLE more (a)",
        "CREATE INDEX more ON episodes (mode)",
        "CREATE VIRTUAL TABLE more USING fts5(a)",
        "ALTER TABLE episodes ADD COLUMN more AS (zeroblob(1000000000))",
        "DROP TABLE writers",
    ],
)
def test_a_file_with_anything_but_the_tables_is_refused(path: Path, script: str) -> None:
    change(path, script)
    before = path.read_bytes()
    assert reason(path) == ELSE
    assert path.read_bytes() == before


def test_a_file_that_an_earlier_program_has_written_is_read_and_resumed(tmp_path: Path) -> None:
    path = tmp_path / "r.sqlite"
    change(path, WRITTEN_BEFORE)
    Store(path, read_only=True).close()
    with Store(path) as store:
        number = store.case_id(make_case({}))
        store.add(number, [row(0, battery_left=-3)], "a program")
        store.check_rows()
        assert store.episodes() == [("a program", 1)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"tableepisodes", b"tableepi\xffodes", "codec can't decode byte 0xff"),
        (b"CREATE TABLE cases", b"CREATE TABLE c\xffses", "malformed database schema (cases)"),
        (b"INTEGER PRIMARY KEY, settings", b"INTEGER PRIM\xffRY KEY, settings", "Could not decode"),
        (b"CREATE TABLE", b"CREATE GRILL", "malformed database schema"),
        (b"mode TEXT", b"mope TEXT", ELSE),
    ],
)
def test_a_wrong_byte_in_the_schema_is_an_error(
    path: Path, refused: Refused, old: bytes, new: bytes, message: str
) -> None:
    path.write_bytes(path.read_bytes().replace(old, new))
    for words in (["report", path], ["sweep", "-o", path], ["export", path, f"{path}.csv"]):
        assert refused(*words).startswith(f"{path}: ")
    assert message in reason(path)


@pytest.mark.parametrize("column", ["settings", "mode", "name"])
def test_a_wrong_byte_in_a_text_is_an_error(path: Path, refused: Refused, column: str) -> None:
    table = {"settings": "cases", "mode": "episodes", "name": "programs"}[column]
    change(path, f"UPDATE {table} SET {column} = CAST(x'61ff' AS TEXT)")
    for words in (["report", path], ["export", path, path.with_suffix(".csv")]):
        assert refused(*words).startswith(f"{path}: ")


def test_a_page_that_is_used_twice_is_refused(path: Path) -> None:
    with Store(path) as store:
        store.add(1, [row(n) for n in range(1, 2000)])
        [page_size] = next(store.query("PRAGMA page_size"))
        statement = "SELECT rootpage FROM sqlite_master WHERE name = 'episodes'"
        [root] = next(store.query(statement))
    data = bytearray(path.read_bytes())
    begin = (root - 1) * page_size
    assert data[begin] == 2, "the root has pages below it"
    first = begin + int.from_bytes(data[begin + 12 : begin + 14])
    second = begin + int.from_bytes(data[begin + 14 : begin + 16])
    data[second : second + 4] = data[first : first + 4]
    path.write_bytes(data)
    message = reason(path)
    assert message.startswith("it is damaged: ")
    assert "2nd reference to page" in message


def test_a_schema_without_an_end_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "MAX_SCHEMA_STEPS", 1)
    assert reason(path) == "its schema has no end"


def test_long_texts_are_not_read(path: Path) -> None:
    change(path, "UPDATE cases SET settings = ?", "x" * 70_000_000)
    with Store(path, read_only=True) as store, pytest.raises(StoreError, match="blob too big"):
        store.cases()


@pytest.mark.parametrize(
    ("table", "statement"),
    [
        *(("episodes", each) for each in (
            "mode = 'sold'", "seed = -1", "steps = -5", "steps = 'many'", "row = -1", "row = 1.5",
            "seconds = 'long'", "seconds = 9e999", "reward = -9e999", "joules = 1e31",
            "case_id = 77",
        )),
        *(("shifts", each) for each in (
            "mode = 'delivered'", "seed = -1", "orders = 1.5", "seconds = 'x'", "per_hour = 1e31",
            "on_time = 'x'", "case_id = 9",
        )),
    ],
)  # fmt: skip
def test_a_row_that_no_sweep_has_written_is_an_error(
    path: Path, table: str, statement: str
) -> None:
    fill(path, [({"robots": 2}, [fleet_row(0)])])
    with Store(path) as store:
        store.check_rows()
    change(path, f"UPDATE {table} SET {statement}")
    with Store(path, read_only=True) as store, pytest.raises(StoreError) as caught:
        store.check_rows()
    assert str(caught.value).startswith(f"{path}: the row of case ")
    assert str(caught.value).endswith(" is damaged")
