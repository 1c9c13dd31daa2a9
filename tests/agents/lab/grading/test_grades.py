"""Tables of grades: what is read, and what is refused before it takes memory."""

import os
from pathlib import Path

import pytest

from agents.errors import GradeError
from agents.lab.grading.grades import MAX_BYTES, load_grades, save_grades

COLUMNS = ["submission", "points", "of", "delivers", "failure", "code", "rubric"]
HEAD = ",".join(COLUMNS)


def test_a_table_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "grades.csv"
    rows = {
        name: dict(
            zip(COLUMNS, (name, points, "30", "10", 'late, "it"\nsays', "c", "r"), strict=True)
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
        ("a,b\n1,2\n", "the column 'submission' is missing"),
        (HEAD.replace("failure,", ""), "the column 'failure' is missing"),
        (f"{HEAD}{',x' * 1000}", "1,007 columns are more than MAX_COLUMNS = 1000"),
        (f"{HEAD}\n\nann,1,30,10,,c,r\nbob,2,30,10,,c\n", "line 4 has 6 fields or no points"),
        (f"{HEAD}\nann,1,30,10,,c,r,more\n", "line 2 has 8 fields or no points"),
        (f"{HEAD}\nann\n", "line 2 has 1 field or no points"),
        (f"{HEAD}\nann,many,30,10,,c,r\n", "could not convert string to float: 'many'"),
        (f"{HEAD}\nann,nan,30,10,,c,r\n", "line 2 has 7 fields or no points"),
        (f'{HEAD}\n"ann', "unexpected end of data"),
        (f"{HEAD}\n\udcff", "can't decode byte 0xff"),
    ],
)
def test_another_file_is_refused_and_stays(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "grades.csv"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(GradeError) as caught:
        load_grades(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: it is no table of grades: ")
    assert reason in line


def test_a_table_that_is_too_long_or_no_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "grades.csv"
    path.write_bytes(b"x" * (MAX_BYTES + 1))
    with pytest.raises(OSError, match="it is longer than 5,000,000 bytes"):
        load_grades(path)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(OSError, match="it is a pipe, not a file"):
        load_grades(path)
