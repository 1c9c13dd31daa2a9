"""The file of results, which stores rows once and keeps them, and files that are damaged."""

import os
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path

import pytest
from helpers.command_line import Refused
from helpers.results_files import change, fill, fleet_row, row

from agents.errors import StoreError
from agents.lab.experiments.case import key_of, make_case
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import FleetRow

CASE, OTHER, FLEET = (make_case(each) for each in ({"battery": 20}, {"battery": 30}, {"robots": 2}))
EVERY = range(2**63 - 1)
PATH = Path("r.sqlite")
OLD, NEW = "warehouse-lab 1 (a), numpy 2", "warehouse-lab 1 (b), numpy 2"


def begun() -> int:
    """Write the first episode of a case, and return the number of the case."""
    fill(PATH, [({"battery": 20}, [row(1)])])
    return 1


def refused(*, read_only: bool = False) -> str:
    with pytest.raises(StoreError) as caught:
        Store(PATH, read_only=read_only)
    return str(caught.value).removeprefix(f"{PATH}: ")


def test_rows_of_lone_robots_and_fleets_are_kept_and_never_replaced() -> None:
    rows = [row(3, reward=-0.1 - 0.2, joules=1 / 3), row(1, "stalled", needed=None), row(2**62)]
    shifts = [fleet_row(3, per_hour=None), fleet_row(5)]
    with Store(PATH) as store:
        alone, fleet = store.case_ids([CASE, FLEET])
        store.add(alone, rows, OLD)
        store.add(fleet, shifts, NEW)
    with Store(PATH) as store:
        store.add(alone, [row(4), row(3, "stalled")], OLD)
        store.add(fleet, [fleet_row(5, "late")], NEW)
        assert store.case_ids([FLEET, CASE, OTHER]) == [fleet, alone, 3]
    with Store(PATH, read_only=True) as store:
        assert store.cases() == {alone: CASE, fleet: FLEET, 3: OTHER}
        assert list(store.rows(alone)) == sorted([*rows, row(4)])
        assert list(store.rows(fleet, FleetRow)) == shifts
        assert store.seeds_done(alone, range(2, 2**62)) == {3, 4}
        assert store.programs() == {alone: OLD, fleet: NEW}


def test_rows_are_added_in_one_transaction_that_is_on_the_disk() -> None:
    case_id = begun()
    with Store(PATH) as store, Store(PATH, read_only=True) as reader:
        assert next(store.query("PRAGMA synchronous")) == (2,)
        broken = row(3)._replace(steps={})  # type: ignore[arg-type]
        with pytest.raises(StoreError, match=r"r\.sqlite"):
            store.add(case_id, [row(2), broken, row(4)])
        assert reader.seeds_done(case_id, EVERY) == {1}
        store.add(case_id, [row(2)])
        assert reader.seeds_done(case_id, EVERY) == {1, 2}
        with pytest.raises(StoreError, match="readonly"):
            reader.add(case_id, [row(3)])


def test_episodes_of_another_program_are_not_added_to_a_case() -> None:
    with Store(PATH) as store:
        case_id, other = store.case_ids([CASE, OTHER])
        store.add(case_id, [row(1)], OLD)
        store.add(other, [row(1)], NEW)
        with pytest.raises(StoreError) as caught:
            store.add(case_id, [row(2)], NEW)
        assert str(caught.value) == (
            f"{PATH}: the episodes with battery=20 were run by {OLD}, and new ones would be "
            f"run by {NEW}; write to another file"
        )
        assert store.seeds_done(case_id, EVERY) == {1}


def database() -> None:
    PATH.touch()
    change(PATH, "CREATE TABLE cases (id)")


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (database, "it was not written by a sweep of this version"),
        (lambda: PATH.write_text("These are no results.\n" * 100), "file is not a database"),
        (lambda: os.mkdir(PATH), "it is a folder, not a file"),
    ],
)
def test_another_file_is_an_error_and_is_not_changed(
    make: Callable[[], None], message: str, read_only: bool
) -> None:
    make()
    before = PATH.read_bytes() if PATH.is_file() else b""
    assert refused(read_only=read_only) == message
    assert [each.name for each in PATH.parent.iterdir()] == [PATH.name], "it gets no journal"
    assert (PATH.read_bytes() if PATH.is_file() else b"") == before


def test_an_empty_file_becomes_a_file_of_results() -> None:
    assert refused(read_only=True) == "there is no such file"
    PATH.touch()
    assert refused(read_only=True) == "the file has no results"
    with Store(PATH) as store:
        assert store.cases() == {}


def test_a_full_disk_is_an_error_and_earlier_rows_are_kept() -> None:
    case_id = begun()
    with Store(PATH) as store:
        [(pages,)] = store.query("PRAGMA page_count")
        list(store.query(f"PRAGMA max_page_count = {pages + 2}"))
        with pytest.raises(StoreError) as caught:
            store.add(case_id, [row(seed) for seed in range(50, 5000)])
        assert str(caught.value) == f"{PATH}: database or disk is full"
        assert store.seeds_done(case_id, EVERY) == {1}


def open_many(number: int, files: int, start: Barrier) -> None:
    """Open each file at the same time as other processes, and add two rows to it."""
    for file in range(files):
        start.wait(20)
        with Store(f"{file}.sqlite") as store:
            store.add(store.case_ids([CASE])[0], [row(number), row(99)])


def test_several_sweeps_may_create_and_use_the_same_file_at_once() -> None:
    context, files, count = get_context("fork"), 8, 3
    start = context.Barrier(count)
    processes = [
        context.Process(target=open_many, args=(number, files, start)) for number in range(count)
    ]
    for each in processes:
        each.start()
    for each in processes:
        each.join(60)
    assert [each.exitcode for each in processes] == [0] * count
    for file in range(files):
        with Store(f"{file}.sqlite", read_only=True) as store:
            assert store.seeds_done(1, EVERY) == {*range(count), 99}


# Damaged files.


def changed(**values: object) -> str:
    case = {**make_case({}), **values}
    return key_of({name: value for name, value in case.items() if value is not None})


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ("{", "Expecting property name"),
        (changed(agent=5), "agent is 5; allowed: a name of at most"),
        (changed(batery=5), "no setting is called 'batery'"),
        (changed(tiles=[["#"]]), ""),
        (changed(tiles=None), "it has no tiles"),
        (changed(battery=None), "it has no battery"),
    ],
)
def test_an_invalid_case_is_an_error_with_the_reason(settings: str, reason: str) -> None:
    Store(PATH).close()
    change(PATH, "INSERT INTO cases (settings) VALUES (?)", settings)
    with Store(PATH, read_only=True) as store, pytest.raises(StoreError) as caught:
        store.cases()
    assert str(caught.value).startswith(f"{PATH}: case 1 is invalid: ")
    assert reason in str(caught.value)


def test_a_case_with_a_backend_that_is_not_installed_is_read() -> None:
    case = {**CASE, "backend": "hover"}
    with Store(PATH) as store:
        [number] = store.case_ids([case])
        assert store.cases() == {number: case}


@pytest.mark.parametrize(
    ("change_of_case_1", "change_of_case_2"),
    [
        ("mode = 'sold'", "mode = 'delivered'"),
        ("steps = -5", "orders = 1.5"),
        ("joules = 'many'", "per_hour = 'fast'"),
        ("row = NULL", "seconds = NULL"),
    ],
)
def test_a_row_that_no_sweep_has_written_is_an_error(
    change_of_case_1: str, change_of_case_2: str
) -> None:
    fill(PATH, [({}, [row(0, battery_left=-3)]), ({"robots": 2}, [fleet_row(0)])])
    change(PATH, f"UPDATE episodes SET {change_of_case_1} WHERE case_id = 1")
    change(PATH, f"UPDATE episodes SET {change_of_case_2} WHERE case_id = 2")
    with Store(PATH, read_only=True) as store:
        for number, kind in enumerate((type(row(0)), FleetRow), start=1):
            with pytest.raises(StoreError) as caught:
                [*store.rows(number, kind)]
            assert str(caught.value) == f"{PATH}: the row of case {number}, seed 0 is damaged"


@pytest.mark.parametrize(
    ("old", "new"), [(b"tableepisodes", b"tableepi\xffodes"), (b"program TEXT", b"pro\xffram TEXT")]
)
def test_a_wrong_byte_in_the_schema_is_an_error(refused: Refused, old: bytes, new: bytes) -> None:
    begun()
    PATH.write_bytes(PATH.read_bytes().replace(old, new))
    for words in (["report", PATH], ["sweep", "-n", 1, "-o", PATH], ["export", PATH, "r.csv"]):
        assert refused(*words).startswith(f"{PATH}: ")


def test_lost_pages_are_an_error_before_anything_is_written() -> None:
    fill(PATH, [({}, [row(seed) for seed in range(2000)])])
    data = PATH.read_bytes()
    PATH.write_bytes(data[: len(data) // 2] + bytes(len(data) - len(data) // 2))
    assert refused() == refused(read_only=True) != ""


def test_writing_to_a_removed_file_is_an_error() -> None:
    case_id = begun()
    with Store(PATH) as store:
        PATH.rename(PATH.with_name("away.sqlite"))
        with pytest.raises(StoreError, match=r"^r\.sqlite: "):
            store.add(case_id, [row(2)])
