"""The file of results, which stores rows once and keeps them, and files from strangers."""

import os
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path

import pytest
from helpers.command_line import Refused
from helpers.results_files import change, fill, fleet_row, row

from agents.errors import StoreError
from agents.lab.experiments.case import key_of, make_case, row_type
from agents.lab.experiments.store import APPLICATION, VERSION, Store
from agents.lab.trials.rows import FleetRow, Row

CASE, OTHER = make_case({"battery": 20}), make_case({"battery": 30})
EVERY = range(2**63 - 1)
ALL = f"SELECT case_id, {', '.join(Row._fields)} FROM episodes ORDER BY case_id, seed"


PATH = Path("r.sqlite")


def begun(path: Path = PATH) -> int:
    """Write the first episode of a case, and return the number of the case."""
    fill(path, [({"battery": 20}, [row(1)])])
    return 1


def refused(path: Path = PATH, *, read_only: bool = False) -> str:
    with pytest.raises(StoreError) as caught:
        Store(path, read_only=read_only)
    return str(caught.value)


def test_rows_are_equal_after_reopening() -> None:
    rows = [row(3, reward=-0.1 - 0.2, joules=1 / 3), row(1, "stalled", needed=None), row(2**62)]
    with Store(PATH) as store:
        case_id = store.case_id(CASE)
        store.add(case_id, rows)
    with Store(PATH) as store:
        assert [found[1:] for found in store.query(ALL)] == sorted(rows)
        assert store.cases() == {case_id: CASE}
        assert store.case_id(CASE) == case_id
        store.add(case_id, [row(4), row(3), row(3, "stalled")])
        assert [found[1:] for found in store.query(ALL)] == sorted([*rows, row(4)]), "not replaced"


def test_a_file_in_a_read_only_folder_is_read_unless_rows_would_be_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun()
    with monkeypatch.context() as patch:
        patch.setattr("os.access", lambda *_: False)
        with Store(PATH, read_only=True) as store:
            assert store.seeds_done(1, EVERY) == {1}
            assert [each.name for each in PATH.parent.iterdir()] == [PATH.name]
    with Store(PATH) as store:
        store.add(1, [row(2)])
        monkeypatch.setattr("os.access", lambda *_: False)
        assert "its newest rows are still in r" in refused(read_only=True)


def test_a_case_with_a_backend_that_is_not_installed_is_read() -> None:
    case = {**PLAIN, "backend": "hover"}
    with Store(PATH) as store:
        number = store.case_id(case)
        assert store.cases() == {number: case}


def test_rows_are_added_in_one_transaction() -> None:
    case_id = begun()
    with Store(PATH) as store:
        broken = row(3)._replace(steps={})  # type: ignore[arg-type]
        with pytest.raises(StoreError, match=r"r\.sqlite"):
            store.add(case_id, [row(2), broken, row(4)])
        assert store.seeds_done(case_id, EVERY) == {1}
        store.add(case_id, [row(2)])
        assert store.seeds_done(case_id, EVERY) == {1, 2}


def test_each_batch_is_committed_and_synchronised_to_disk() -> None:
    with Store(PATH) as writer:
        case_id = writer.case_id(CASE)
        writer.add(case_id, [row(1)])
        assert next(writer.query("PRAGMA synchronous")) == (2,)
        assert next(writer.query("PRAGMA journal_mode")) == ("wal",), "a kill ends no half of it"
        with Store(PATH, read_only=True) as reader:
            assert reader.seeds_done(case_id, EVERY) == {1}
            with pytest.raises(StoreError, match="readonly"):
                reader.add(case_id, [row(2)])


def test_an_empty_file_becomes_a_file_of_results_with_its_id_and_version() -> None:
    PATH.touch()
    assert refused(read_only=True) == f"{PATH}: the file has no results"
    with Store(PATH) as store:
        assert store.cases() == {}
        assert next(store.query("PRAGMA application_id")) == (APPLICATION,)
        assert next(store.query("PRAGMA user_version")) == (VERSION,)


def database(path: Path) -> None:
    path.touch()
    change(path, "CREATE TABLE cases (id)")


def text(path: Path) -> None:
    path.write_text("These are no results.\n" * 100)


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (database, "this database does not have the results of a sweep"),
        (text, "file is not a database"),
        (os.mkdir, "it is a folder, not a file"),
        (os.mkfifo, "it is a pipe, not a file"),
    ],
)
def test_another_file_is_an_error_and_is_not_changed(
    make: Callable[[Path], None], message: str, read_only: bool
) -> None:
    make(PATH)
    before = PATH.read_bytes() if PATH.is_file() else b""
    assert refused(read_only=read_only) == f"{PATH}: {message}"
    assert [each.name for each in PATH.parent.iterdir()] == [PATH.name], "it gets no journal"
    assert (PATH.read_bytes() if PATH.is_file() else b"") == before


def test_a_full_disk_is_an_error_and_earlier_rows_are_kept() -> None:
    with Store(PATH) as store:
        case_id = store.case_id(CASE)
        store.add(case_id, [row(seed) for seed in range(50)])
        [pages] = next(store.query("PRAGMA page_count"))
        list(store.query(f"PRAGMA max_page_count = {pages + 2}"))
        with pytest.raises(StoreError) as caught:
            store.add(case_id, [row(seed) for seed in range(50, 5000)])
        assert str(caught.value) == f"{PATH}: database or disk is full"
        assert store.seeds_done(case_id, EVERY) == set(range(50))


def open_many(folder: Path, number: int, files: int, start: Barrier) -> None:
    """Open each file at the same time as other processes, and add two rows to it."""
    for file in range(files):
        start.wait(20)
        with Store(folder / f"{file}.sqlite") as store:
            store.add(store.case_id(CASE), [row(number), row(99)])


def test_several_sweeps_may_create_and_use_the_same_file_at_once(tmp_path: Path) -> None:
    context, files, count = get_context("fork"), 8, 3
    start = context.Barrier(count)
    processes = [
        context.Process(target=open_many, args=(tmp_path, number, files, start))
        for number in range(count)
    ]
    for each in processes:
        each.start()
    for each in processes:
        each.join(60)
    assert [each.exitcode for each in processes] == [0] * count
    for file in range(files):
        with Store(tmp_path / f"{file}.sqlite", read_only=True) as store:
            assert len(store.cases()) == 1
            assert store.seeds_done(1, EVERY) == {*range(count), 99}


@pytest.mark.parametrize("is_replaced", [False, True])
def test_writing_to_a_removed_or_replaced_file_is_an_error(is_replaced: bool) -> None:
    case_id = begun()
    with Store(PATH) as store:
        PATH.rename(PATH.with_name("away.sqlite"))
        if is_replaced:
            PATH.write_bytes(b"")
        with pytest.raises(StoreError) as caught:
            store.add(case_id, [row(2)])
    assert str(caught.value) == f"{PATH}: the file has been removed or replaced meanwhile"


PLAIN = make_case({})
TREES = {"robot.mass": 1.0, "layout": "random", "size": "8x8", "density": 0.1}
INVALID = {
    "an agent that is a number": ({"agent": 5}, "agent is 5; allowed: a name of at most"),
    "tiles that are no rows": ({"tiles": [["#"]]}, "tiles is [['#']]; allowed: a list of rows"),
    "no tiles": ({"tiles": None}, "it has no tiles"),
    "an infinite mass": ({**TREES, "robot.mass": float("inf")}, "robot.mass is inf; allowed: "),
    "a fingerprint of another kind": ({"fingerprint": "f"}, "fingerprint is 'f'; allowed: 64 "),
    "no battery": ({"battery": None}, "it has no battery"),
    "many keys": ({f"robot.{'x' * n}": 1.0 for n in range(1, 50)} | {
        f"disturbances.{'x' * n}": 1.0 for n in range(1, 50)}, "keys; MAX_KEYS = 100 are allowed"),
}  # fmt: skip
TEXTS = {
    "not JSON": ("{", "Expecting property name"),
    "deep nesting": (100_000 * "[", "open brackets are more than MAX_DEPTH = 20"),
    "many lists": ('{"a": [' + "[]," * 500_000, "1,000,002 values are more than MAX_ITEMS"),
} | {
    name: (key_of({k: v for k, v in {**PLAIN, **change}.items() if v is not None}), reason)
    for name, (change, reason) in INVALID.items()
}  # fmt: skip


@pytest.mark.parametrize(("settings", "reason"), TEXTS.values(), ids=TEXTS)
def test_an_invalid_case_is_an_error_with_the_reason(settings: str, reason: str) -> None:
    Store(PATH).close()
    change(PATH, "INSERT INTO cases (settings) VALUES (?)", settings)
    with Store(PATH, read_only=True) as store, pytest.raises(StoreError) as caught:
        store.cases()
    assert str(caught.value).startswith(f"{PATH}: case 1 is invalid: ")
    assert reason in str(caught.value)


# Programs.

OLD, NEW = "warehouse-lab 1 (a), numpy 2", "warehouse-lab 1 (b), numpy 2"


def test_episodes_of_another_program_are_not_added_to_a_case() -> None:
    with Store(PATH) as store:
        case_id, other = store.case_id(CASE), store.case_id(OTHER)
        store.add(case_id, [row(1)], OLD)
        store.add(other, [row(1)], NEW)
        with pytest.raises(StoreError) as caught:
            store.add(case_id, [row(2)], NEW)
        assert str(caught.value) == (
            f"{PATH}: the episodes with battery=20 were run by {OLD}, and new ones would be "
            f"run by {NEW}; write to another file"
        )
        store.add(case_id, [row(3)], OLD)
        assert store.episodes() == [(OLD, 2), (NEW, 1)]
        assert {each.seed: program for each, program in store.rows(case_id)} == {1: OLD, 3: OLD}


def test_the_rows_of_fleets_have_a_table_of_their_own() -> None:
    fleet, shifts = make_case({"robots": 2}), [fleet_row(3, per_hour=None), fleet_row(5)]
    with Store(PATH) as store:
        number, alone = store.case_id(fleet), store.case_id(CASE)
        store.add(number, shifts, "one")
        store.add(alone, [row(3)], "one")
        store.add(number, [fleet_row(5, "late")], "one")
        assert [found for found, _ in store.rows(number, FleetRow)] == shifts
        assert [*store.rows(number)] == []
        assert store.seeds_done(number, range(4)) == {3}
        assert (store.count(fleet, range(9)), store.count(CASE, range(9))) == (2, 1)
        assert store.episodes() == [("one", 3)]


# Files from strangers.

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
    """Return the error message, which is the same for reading and for resuming."""
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
        "CREATE TRIGGER t AFTER INSERT ON cases BEGIN DELETE FROM episodes; END",
        "CREATE INDEX more ON episodes (mode)",
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
        assert [found.battery_left for found, _ in store.rows(number)] == [-3]
        assert store.episodes() == [("a program", 1)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"tableepisodes", b"tableepi\xffodes", "codec can't decode byte 0xff"),
        (b"INTEGER PRIMARY KEY, settings", b"INTEGER PRIM\xffRY KEY, settings", "Could not decode"),
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


@pytest.mark.parametrize(
    ("table", "statement"),
    [
        *(("episodes", each) for each in (
            "mode = 'sold'", "steps = -5", "steps = 'many'", "seconds = 'long'", "joules = 1e31",
        )),
        *(("shifts", each) for each in (
            "mode = 'delivered'", "orders = 1.5", "per_hour = 1e31",
        )),
    ],
)  # fmt: skip
def test_a_row_that_no_sweep_has_written_is_an_error(
    path: Path, table: str, statement: str
) -> None:
    fill(path, [({"robots": 2}, [fleet_row(0)])])
    kind = FleetRow if table == "shifts" else Row
    with Store(path) as store:
        [number] = [each for each, case in store.cases().items() if row_type(case) is kind]
        assert len([*store.rows(number, kind)]) == 1
    change(path, f"UPDATE {table} SET {statement}")
    with Store(path, read_only=True) as store, pytest.raises(StoreError) as caught:
        [*store.rows(number, kind)]
    assert str(caught.value).startswith(f"{path}: the row of case ")
    assert str(caught.value).endswith(" is damaged")
