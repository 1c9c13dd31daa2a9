"""Late submissions: what days take, and tables of them."""

from pathlib import Path

import pytest

from agents.errors import GradeError
from agents.lab.grading.late import LateRule, load_days


def test_each_day_takes_points_and_after_the_last_there_are_none() -> None:
    rule = LateRule(points=10, days=2)
    assert [rule.taken(days, 75) for days in range(4)] == [0, 10, 20, 75]
    assert rule.taken(2, 15) == 15
    assert LateRule().taken(9, 75) == 0


def test_a_table_of_days_is_read_and_another_one_refused(tmp_path: Path) -> None:
    path = tmp_path / "late.csv"
    path.write_text("\ufeffsubmission,more,days\nann.py,x,2\n=bob,,0\n", encoding="utf-8")
    assert load_days(path) == {"ann.py": 2, "=bob": 0}
    for text, reason in {
        "submission\nann": "the column 'days' is missing",
        "": "the column 'submission' is missing",
        "submission,days\nann,-1": "line 2: days is '-1'; allowed: a whole number from 0 to 3650",
        "submission,days\nann,\u00b2": "line 2: days is",
        "submission,days\nann": "line 2: days is ''",
        f"submission,days\nann,{'9' * 5000}": "line 2: days is '99999999999999999999'; allowed",
    }.items():
        path.write_text(text, encoding="utf-8")
        with pytest.raises(GradeError, match="it is no table of late submissions") as caught:
            load_days(path)
        assert reason in str(caught.value)
