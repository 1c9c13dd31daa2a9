"""``warehouse export`` of results: the same table as CSV and Parquet, never a partial file."""

import csv
import os
import sqlite3
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from helpers.command_line import command, refusal
from helpers.results_files import fleet_row
from pyarrow import parquet

from agents.lab.commands.export import table as table_export
from agents.lab.commands.export.export import export
from agents.lab.commands.export.table import columns_of, lines_of
from agents.lab.experiments.case import TILES, make_case
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row
from warehouse_core import DEFAULT_LAYOUT

HEAVY = make_case({"backend": "physics", "robot.mass": 70.0})
RANDOM = make_case({"layout": "random", "density": 0.3, "escape": False})
ODD_NAME = 'my, "agent"\nof two lines.py:Müller'


def row(seed: int, mode: str = "delivered", needed: int | None = 9) -> Row:
    return Row(seed, mode, 10, needed, -0.1 - 0.2, 3, 10.5, 1 / 3, 4, 5)


def stored(path: Path, *cases: Any) -> Path:
    with Store(path) as store:
        for case in cases:
            rows = [row(3), row(1, "unreachable", None), row(2**62)]
            store.add(store.case_id(case), rows, "warehouse-lab 1")
    return path


@pytest.fixture
def results(tmp_path: Path) -> Path:
    return stored(tmp_path / "r.sqlite", make_case({}), HEAVY, RANDOM)


def table_of(results: Path) -> list[dict[str, Any]]:
    with Store(results, read_only=True) as store:
        columns = columns_of(store)
        return [dict(zip(columns, line, strict=True)) for line in lines_of(store, columns)]


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
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
    assert {line["joules"] for line in table} == {1 / 3}
    assert {line["program"] for line in table} == {"warehouse-lab 1"}


@pytest.mark.parametrize("suffix", [".csv", ".CSV"])
def test_csv_has_the_values_of_the_store(
    capsys: pytest.CaptureFixture[str], results: Path, tmp_path: Path, suffix: str
) -> None:
    target = tmp_path / f"t{suffix}"
    assert command(capsys, "export", results, target) == (0, f"saved {target}\n", "")
    expected = [
        {name: "" if value is None else str(value) for name, value in line.items()}
        for line in table_of(results)
    ]
    assert read_csv(target) == expected
    assert names(tmp_path) == {"r.sqlite", target.name}


@pytest.mark.parametrize("lines", [4, 50_000])
def test_parquet_has_the_values_of_the_store_with_their_types(
    capsys: pytest.CaptureFixture[str],
    results: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    lines: int,
) -> None:
    monkeypatch.setattr(table_export, "LINES_AT_ONCE", lines)
    target = tmp_path / "t.parquet"
    assert command(capsys, "export", results, target).code == 0
    found = parquet.read_table(target)
    assert found.to_pylist() == table_of(results)
    kinds = {field.name: field.type for field in found.schema}
    assert kinds["agent"] == kinds["mode"] == kinds[TILES] == pa.string()
    assert kinds["escape"] == pa.bool_()
    assert kinds["battery"] == kinds["seed"] == kinds["needed"] == pa.int64()
    assert kinds["robot.mass"] == kinds["density"] == kinds["reward"] == pa.float64()
    assert parquet.read_metadata(target).num_row_groups == -(-9 // lines)


def test_special_characters_in_names_are_preserved(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    results = stored(tmp_path / "r.sqlite", {**make_case({}), "agent": ODD_NAME})
    for name in ("t.csv", "t.parquet"):
        assert command(capsys, "export", results, tmp_path / name).code == 0
    assert {line["agent"] for line in read_csv(tmp_path / "t.csv")} == {ODD_NAME}
    column = parquet.read_table(tmp_path / "t.parquet")["agent"]
    assert set(column.to_pylist()) == {ODD_NAME}


def test_bytes_of_a_name_that_are_no_utf8_are_escaped(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    names = ["hall\udcff.txt", "hall\udcfe.txt"]
    results = stored(tmp_path / "r.sqlite", *({**make_case({}), "layout": n} for n in names))
    for name in ("t.csv", "t.parquet"):
        assert command(capsys, "export", results, tmp_path / name).code == 0
    escaped = {"hall\\udcff.txt", "hall\\udcfe.txt"}
    assert {line["layout"] for line in read_csv(tmp_path / "t.csv")} == escaped
    assert set(parquet.read_table(tmp_path / "t.parquet")["layout"].to_pylist()) == escaped


@pytest.mark.parametrize("name", ['=HYPERLINK("x")', "-1", "\t=1"])
def test_names_that_look_like_formulas_are_escaped_in_csv(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    results = stored(tmp_path / "r.sqlite", {**make_case({}), "agent": name})
    assert command(capsys, "export", results, tmp_path / "t.csv").code == 0
    [line, *_] = read_csv(tmp_path / "t.csv")
    assert line["agent"] == f"'{name}"
    assert line["reward"] == str(-0.1 - 0.2), "a negative number is not escaped"


def test_results_without_episodes_are_an_empty_table(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    results = tmp_path / "r.sqlite"
    Store(results).close()
    for name in ("t.csv", "t.parquet"):
        assert command(capsys, "export", results, tmp_path / name).code == 0
    assert (tmp_path / "t.csv").read_text().splitlines() == [",".join([*Row._fields, "program"])]
    assert parquet.read_table(tmp_path / "t.parquet").num_rows == 0


def test_a_missing_results_file_is_an_error_with_its_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    missing = tmp_path / "r.sqlite"
    line = refusal(capsys, "export", missing, tmp_path / "t.csv")
    assert line == f"{missing}: there is no such file"
    assert names(tmp_path) == set()


@pytest.mark.parametrize("name", ["t.xlsx", "t"])
def test_an_unknown_suffix_is_an_error_that_lists_the_allowed_ones(
    capsys: pytest.CaptureFixture[str], results: Path, tmp_path: Path, name: str
) -> None:
    line = refusal(capsys, "export", results, tmp_path / name)
    assert str(tmp_path / name) in line
    assert "allowed: .csv, .parquet" in line
    assert names(tmp_path) == {"r.sqlite"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_path_that_cannot_be_written_is_an_error_with_its_name(
    capsys: pytest.CaptureFixture[str], results: Path, tmp_path: Path, suffix: str
) -> None:
    assert "nowhere" in refusal(capsys, "export", results, tmp_path / f"nowhere/t{suffix}")
    (tmp_path / f"folder{suffix}").mkdir()
    assert "folder" in refusal(capsys, "export", results, tmp_path / f"folder{suffix}")
    assert names(tmp_path) == {"r.sqlite", f"folder{suffix}"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_an_export_that_fails_keeps_the_existing_file(
    capsys: pytest.CaptureFixture[str],
    results: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    suffix: str,
) -> None:
    monkeypatch.setattr(table_export, "LINES_AT_ONCE", 1)
    target = tmp_path / f"t{suffix}"
    target.write_text("existing")
    database = sqlite3.connect(results)
    database.execute("UPDATE episodes SET mode = CAST(x'ff' AS TEXT) WHERE case_id = 3")
    database.commit()
    database.close()
    assert str(results) in refusal(capsys, "export", results, target)
    assert target.read_text() == "existing"
    assert names(tmp_path) == {"r.sqlite", target.name}


def test_without_pyarrow_the_error_gives_the_command_that_installs_it(
    capsys: pytest.CaptureFixture[str],
    results: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    line = refusal(capsys, "export", results, tmp_path / "t.parquet")
    assert line == "Parquet needs pyarrow: pip install 'pyarrow>=15'"
    assert command(capsys, "export", results, tmp_path / "t.csv").code == 0
    assert names(tmp_path) == {"r.sqlite", "t.csv"}


@pytest.mark.parametrize("value", ["many", True, 10**30, [3]])
def test_an_invalid_setting_in_the_file_is_a_one_line_error(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, value: object
) -> None:
    results = stored(tmp_path / "r.sqlite", make_case({}), {**make_case({}), "battery": value})
    line = refusal(capsys, "export", results, tmp_path / "t.parquet")
    assert line.startswith(f"{results}: ")
    assert names(tmp_path) == {"r.sqlite"}


def test_an_export_does_not_change_the_results(
    capsys: pytest.CaptureFixture[str], results: Path
) -> None:
    before = results.read_bytes(), os.stat(results).st_mtime_ns
    command(capsys, "export", results, results.with_name("t.csv"))
    assert (results.read_bytes(), os.stat(results).st_mtime_ns) == before


def test_an_invalid_result_in_the_file_is_a_one_line_error(
    capsys: pytest.CaptureFixture[str], results: Path, tmp_path: Path
) -> None:
    database = sqlite3.connect(results)
    database.execute("UPDATE episodes SET steps = 'many' WHERE case_id = 3")
    database.commit()
    database.close()
    assert "many" in refusal(capsys, "export", results, tmp_path / "t.parquet")
    assert names(tmp_path) == {"r.sqlite"}


def test_lone_robots_and_fleets_share_a_table(tmp_path: Path) -> None:
    path = stored(tmp_path / "r.sqlite", make_case({}))
    with Store(path) as store:
        store.add(store.case_id(make_case({"robots": 2})), [fleet_row(4, on_time=None)], "p")
    *_, alone, fleet = table_of(path)
    assert (fleet["robots"], fleet["seed"], fleet["per_hour"]) == (2, 4, 180.0)
    assert fleet["on_time"] is fleet["reward"] is fleet["stations"] is None
    assert alone["robots"] is alone["per_hour"] is None
    assert alone["reward"] == -0.1 - 0.2
    for suffix in (".csv", ".parquet"):
        export(path, tmp_path / f"t{suffix}")
    assert parquet.read_table(tmp_path / "t.parquet")["per_hour"].to_pylist()[-1] == 180.0
    assert read_csv(tmp_path / "t.csv")[-1]["on_time"] == ""
