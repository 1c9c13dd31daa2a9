import csv
from math import inf, nan
from pathlib import Path

import pytest
from helpers.spreadsheets import FORMS, save_again

from warehouse_core import Order
from warehouse_core.files.tables import number_in, read_table, whole_in, write_table
from warehouse_core.orders import load_orders, save_orders


def test_no_text_runs_in_a_spreadsheet_and_nothing_known_is_an_empty_field(tmp_path: Path) -> None:
    lines = [["=1+1", -1.5, None], ["a\nb", nan, inf], ["-", 1, 2]]
    write_table(tmp_path / "a.csv", ["name", "x", "y"], lines)
    text = (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert [*csv.reader(text.splitlines())] == [
        ["name", "x", "y"], ["'=1+1", "-1.5", ""], ["a b", "", "inf"], ["-", "1", "2"],
    ]  # fmt: skip


def test_a_table_with_other_characters_than_ascii_begins_with_a_mark(tmp_path: Path) -> None:
    write_table(tmp_path / "a.csv", ["name"], [["Zo\u00eb"]])
    assert (tmp_path / "a.csv").read_bytes() == b"\xef\xbb\xbfname\nZo\xc3\xab\n"
    assert [*read_table(tmp_path / "a.csv", ["name"], 100, dict)] == [{"name": "Zo\u00eb"}]


@pytest.mark.parametrize("form", FORMS)
def test_a_table_is_read_in_every_form_in_which_spreadsheets_save_it(tmp_path, form: str) -> None:
    path, orders = (
        tmp_path / "orders.csv",
        [Order(0, 50, (1, 3), (5, 6)), Order(2, 9, (1, 1), (2, 2), 4)],
    )
    save_orders(path, orders)
    save_again(path, form)
    assert load_orders(path) == orders
    lines = [['Zo\u00eb, the "2nd"', 2, 27.5], ["bob;py", 0, 3]]
    write_table(path, ["name", "days", "points"], lines)
    save_again(path, form)

    def made(row: dict[str, str]) -> list[object]:
        return [row["name"], whole_in(row, "days"), number_in(row, "points")]

    assert [*read_table(path, ["name", "days", "points"], 1000, made, "name")] == lines


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "line 1: the column 'name' is missing"),
        ("name,Name\n", "line 1: the column 'name' is there twice"),
        ("name,x\na,1\nb\n", "line 3: 1 field, not 2"),
        ("name,x\na,1\n\nb,2\na,3\n", "line 5: name 'a' is in line 2 too"),
        ("sep=;\nname;x\na;1\na;2\n", "line 4: name 'a' is in line 3 too"),
        ('name,x\n"a', "line 2: unexpected end of data"),
        ("name,x\na\u00e9", "line 2: can't decode byte 0xe9; save the table as CSV in UTF-8"),
        (f"name{',x' * 1000}", "line 1: 1,001 columns are more than MAX_COLUMNS = 1000"),
        ("name,x\na,12x", "line 2: x is '12x'; allowed: a whole number from 1 to 9"),
        ("name,x\na,10", "line 2: x is '10'; allowed: a whole number from 1 to 9"),
        ("name,x\na,0", "line 2: x is '0'; allowed: a whole number from 1 to 9"),
    ],
)
def test_another_file_is_refused_with_its_line(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=reason):
        list(read_table(path, ["name"], 10_000, lambda row: whole_in(row, "x", 1, 9), "name"))


@pytest.mark.parametrize("text", ["", "many", "nan", "inf", "1,2,3", "1,234.5"])
def test_what_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=f"x is '{text}'; allowed: a number"):
        number_in({"x": text}, "x")
    assert [number_in({"x": text}, "x") for text in ("1,5", "-2.5", "1e+06")] == [1.5, -2.5, 1e6]


def test_an_error_of_writing_leaves_the_old_table(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    write_table(path, ["x"], [[1]])

    def lines():
        yield [2]
        raise RuntimeError

    with pytest.raises(RuntimeError):
        write_table(path, ["x"], lines())
    assert path.read_text() == "x\n1\n"


def test_a_name_that_looks_like_a_formula_survives(tmp_path: Path) -> None:
    names = ["@ann", "=1+1", "-7", "'quoted", "+"]
    write_table(tmp_path / "t.csv", ["name"], [[name] for name in names])
    assert "'=1+1" in (tmp_path / "t.csv").read_text()
    read = read_table(tmp_path / "t.csv", ["name"], 1000, lambda row: row["name"])
    assert [*read] == names
