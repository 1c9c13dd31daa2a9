"""The table that ``warehouse export`` writes of results, which is never incomplete."""

import csv
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.results_files import fleet_row

from agents.lab.commands.export import save_file
from agents.lab.datasets.table import columns_of, lines_of
from agents.lab.experiments.case import TILES, make_case
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row
from warehouse_core import DEFAULT_LAYOUT
from warehouse_core.wording import printable

HEAVY = make_case({"backend": "physics", "robot.mass": 70.0})
RANDOM = make_case({"layout": "random", "density": 0.3, "escape": False})
ODD_NAME = 'my, "agent"\nof two lines.py:Müller'


def row(seed: int, mode: str = "delivered", needed: int | None = 9) -> Row:
    return Row(seed, mode, 10, needed, -0.1 - 0.2, 3, 10.5, 1 / 3, 4, 5)


def stored(path: Path, *cases: Any) -> Path:
    with Store(path) as store:
        for case in cases:
            rows = [row(3), row(1, "unreachable", None), row(2**62)]
            store.add(store.case_ids([case])[0], rows, "warehouse-lab 1")
    return path


@pytest.fixture
def results(tmp_path: Path) -> Path:
    return stored(tmp_path / "r.sqlite", make_case({}), HEAVY, RANDOM)


def table_of(results: Path) -> list[dict[str, Any]]:
    with Store(results, read_only=True) as store:
        columns = columns_of(store)
        return [dict(zip(columns, line, strict=True)) for line in lines_of(store, columns)]


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file))


def names(folder: Path) -> set[str]:
    return {each.name for each in folder.iterdir()}


def test_each_line_is_an_episode_with_its_settings(results: Path) -> None:
    table = table_of(results)
    assert [line["seed"] for line in table] == [1, 3, 2**62] * 3
    assert [line["backend"] for line in table] == ["grid"] * 3 + ["physics"] * 3 + ["grid"] * 3
    assert [line["robot.mass"] for line in table] == [None] * 3 + [70.0] * 3 + [None] * 3
    assert [line["density"] for line in table] == [None] * 6 + [0.3] * 3
    assert [line["escape"] for line in table] == [True] * 6 + [False] * 3
    assert [line[TILES] for line in table] == ["/".join(DEFAULT_LAYOUT.rows)] * 6 + [None] * 3
    assert {line["needed"] for line in table} == {9, None}
    assert [line["joules"] for line in table] == [None] * 3 + [1 / 3] * 3 + [None] * 3
    assert {line["program"] for line in table} == {"warehouse-lab 1"}


def test_csv_has_the_values_of_the_store(warehouse: Warehouse, results: Path, tmp_path) -> None:
    target, before = tmp_path / "t.CSV", (results.read_bytes(), results.stat().st_mtime_ns)
    assert warehouse("export", results, target) == (0, f"saved {target}\n", "")
    assert (results.read_bytes(), results.stat().st_mtime_ns) == before
    expected = [
        {name: "" if value is None else str(value) for name, value in line.items()}
        for line in table_of(results)
    ]
    assert read_csv(target) == expected
    assert names(tmp_path) == {"r.sqlite", target.name}


@pytest.mark.parametrize(
    ("name", "in_csv"),
    [(ODD_NAME, printable(ODD_NAME)), ("hall\udcff.txt", "hall\\udcff.txt"), ("-1", "'-1")],
    ids=["special characters", "no UTF-8", "a number"],
)
def test_names_are_kept_and_never_executed(warehouse, tmp_path, name, in_csv) -> None:
    results = stored(tmp_path / "r.sqlite", {**make_case({}), "agent": name})
    assert warehouse("export", results, tmp_path / "t.csv").code == 0
    lines = read_csv(tmp_path / "t.csv")
    assert {line["agent"] for line in lines} == {in_csv}
    assert {line["reward"] for line in lines} == {str(-0.1 - 0.2)}, "a negative number is kept"


def test_an_export_that_fails_keeps_the_existing_file(refused, results, tmp_path) -> None:
    target = tmp_path / "t.csv"
    target.write_text("existing")
    with closing(sqlite3.connect(results)) as database:
        database.execute("UPDATE episodes SET mode = CAST(x'ff' AS TEXT) WHERE case_id = 3")
        database.commit()
    assert str(results) in refused("export", results, target)
    assert target.read_text() == "existing"
    assert names(tmp_path) == {"r.sqlite", target.name}


def test_a_damaged_result_is_a_one_line_error(refused: Refused, results: Path, tmp_path) -> None:
    with closing(sqlite3.connect(results)) as database:
        database.execute("UPDATE episodes SET steps = 'many' WHERE case_id = 1")
        database.commit()
    line = refused("export", results, tmp_path / "t.csv")
    assert line == f"{results}: the row of case 1, seed 1 is damaged"
    assert names(tmp_path) == {"r.sqlite"}


def test_lone_robots_and_fleets_share_a_table(tmp_path: Path) -> None:
    path = stored(tmp_path / "r.sqlite", make_case({}))
    with Store(path) as store:
        store.add(store.case_ids([make_case({"robots": 2})])[0], [fleet_row(4, on_time=None)], "p")
    *_, alone, fleet = table_of(path)
    assert (fleet["robots"], fleet["seed"], fleet["per_hour"]) == (2, 4, 180.0)
    assert fleet["on_time"] is fleet["reward"] is fleet["stations"] is None
    assert alone["robots"] is alone["per_hour"] is None
    assert alone["reward"] == -0.1 - 0.2
    save_file(path, tmp_path / "t.csv")
    assert read_csv(tmp_path / "t.csv")[-1]["on_time"] == ""
