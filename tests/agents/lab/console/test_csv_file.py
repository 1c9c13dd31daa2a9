import csv
from math import inf, nan
from pathlib import Path

from agents.lab.console.csv_file import write_csv


def test_no_text_runs_in_a_spreadsheet_and_nothing_known_is_an_empty_field(tmp_path: Path) -> None:
    lines = [["=1+1", -1.5, None], ["a\nb", nan, inf]]
    write_csv(tmp_path / "a.csv", ["name", "x", "y"], lines)
    text = (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert [*csv.reader(text.splitlines())] == [
        ["name", "x", "y"], ["'=1+1", "-1.5", ""], ["a b", "", "inf"],
    ]  # fmt: skip
