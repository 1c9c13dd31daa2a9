"""Tables of grades for Moodle and Canvas."""

import csv
from pathlib import Path

from helpers.submissions import write_rubric

from agents.lab.grading.grades import POINTS, failed_row
from agents.lab.grading.lms import save_canvas, save_moodle
from agents.lab.grading.rubric import load_rubric

NAMES = "Ann B_12_assignsubmission_file_", "beebob_34_567_agent.py", "ceecil_LATE_56_7_a b.zip", "d"


def test_students_are_found_by_the_numbers_in_names_or_by_names(tmp_path: Path) -> None:
    rubric, path = load_rubric(write_rubric(tmp_path)), tmp_path / "grades.csv"
    rows = {}
    for points, name in enumerate(NAMES):
        rows[name] = failed_row(name, "why", rubric) | {POINTS: f"{points}"}
    save_moodle(path, rows, rubric)
    with path.open(newline="", encoding="utf-8") as file:
        moodle = [tuple(row.values()) for row in csv.DictReader(file)]
    assert moodle[0] == ("Participant 12", "Ann B", "0", "100", "-", "why")
    assert [row[0] for row in moodle[1:]] == ["beebob_34_567_agent", "ceecil_LATE_56_7_a b", "d"]
    save_canvas(path, rows, rubric)
    with path.open(newline="", encoding="utf-8") as file:
        canvas = [tuple(row.values()) for row in csv.DictReader(file)]
    assert canvas == [
        ("    Points Possible", "", "", "", "", "100"),
        ("", "", "", "Ann B_12_assignsubmission_file_", "", "0"),
        ("beebob", "34", "", "", "", "1"),
        ("ceecil", "56", "", "", "", "2"),
        ("", "", "", "d", "", "3"),
    ]
