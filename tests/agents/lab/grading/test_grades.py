"""Tables of grades: reading, errors, summaries, and files for Moodle and Canvas."""

import csv
from pathlib import Path

import pytest
from helpers.submissions import write_rubric

from agents.errors import GradeError
from agents.lab.grading.grades import (
    POINTS,
    GradeTable,
    failed_row,
    load_days,
    load_grades,
    save_canvas,
    save_grades,
    save_moodle,
    summary_of,
)
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.submissions import Unusable

COLUMNS = ["submission", "points", "of", "delivers", "failure", "code", "rubric"]
HEAD = ",".join(COLUMNS)


def test_a_table_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "grades.csv"
    rows = {
        name: dict(
            zip(COLUMNS, (name, points, "30", "10", 'late, "it"; says', "c", "r"), strict=True)
        )
        for name, points in (("ann", "27.5"), ("bob", "1e+06"))
    }
    assert load_grades(path) == {}
    save_grades(path, COLUMNS, rows)
    assert load_grades(path) == rows


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "the column 'submission' is missing"),
        (HEAD.replace("failure,", ""), "the column 'failure' is missing"),
        (f"{HEAD}\nann,many,30,10,,c,r\n", "line 2: points is 'many'; allowed: a number"),
    ],
)
def test_another_file_is_refused_and_stays(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "grades.csv"
    path.write_text(text)
    with pytest.raises(GradeError) as caught:
        load_grades(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: not a table of grades: ")
    assert reason in line


def test_a_table_of_days_is_read_and_another_one_refused(tmp_path: Path) -> None:
    path = tmp_path / "late.csv"
    path.write_text("\ufeffsubmission,more,days\nann.py,x,2\n=bob,,0\n", encoding="utf-8")
    assert load_days(path) == {"ann.py": 2, "=bob": 0}
    for text, reason in {
        "submission\nann": "the column 'days' is missing",
        "submission,days\nann,-1": "line 2: days is '-1'; allowed: a whole number from 0 to 3650",
    }.items():
        path.write_text(text, encoding="utf-8")
        with pytest.raises(GradeError, match="not a table of late submissions") as caught:
            load_days(path)
        assert reason in str(caught.value)


NAMES = "Ann B_12_assignsubmission_file_", "beebob_34_567_agent.py", "ceecil_LATE_56_7_a b.zip", "d"


def test_students_are_found_by_the_numbers_in_names_or_by_names(tmp_path: Path) -> None:
    rubric, path = load_rubric(write_rubric(tmp_path)), tmp_path / "grades.csv"
    rows = {}
    for points, name in enumerate(NAMES):
        rows[name] = failed_row(Unusable(name, ""), "why", rubric) | {POINTS: f"{points}"}
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


def test_a_class_is_summarised(tmp_path: Path) -> None:
    rubric = load_rubric(write_rubric(tmp_path))
    none = failed_row(Unusable("none", ""), "no file", rubric)
    half = none | {POINTS: "49.5", "delivers": "30", "stays calm": "20"}
    full = none | {each.name: f"{each.points:g}" for each in rubric.criteria} | {POINTS: "100"}
    assert summary_of([none, half, full], rubric) == [
        "mean 49.8, median 49.5; all points: 1, no points: 1",
        "most often missed: 'protocol' (2 of 3 submissions lack points; 33% of the points on "
        "average)",
    ]
    assert summary_of([full], rubric) == ["mean 100.0, median 100; all points: 1, no points: 0"]


def test_a_table_that_another_program_has_changed_is_not_overwritten(tmp_path) -> None:
    path = tmp_path / "grades.csv"
    first, second = GradeTable(path, COLUMNS), GradeTable(path, COLUMNS)
    row = dict(zip(COLUMNS, ("ann", "27", "30", "10", "", "c", "r"), strict=True))
    for points in ("27", "28"):
        first.save({"ann": row | {"points": points}})
    with pytest.raises(GradeError, match=r"grades\.csv: another program has written or removed it"):
        second.save({})
    assert GradeTable(path, COLUMNS).before["ann"]["points"] == "28"
    path.unlink()
    with pytest.raises(GradeError, match="another program has written or removed it"):
        first.save({"ann": row})
    assert not path.exists()
