"""Folders of classes from learning platforms and systems: one row for each student."""

import sys
from pathlib import Path
from typing import Any

import pytest
from helpers.classes import DOUBLE, SYSTEMS, write_class
from helpers.executors import Here
from helpers.spreadsheets import save_again
from helpers.submissions import write_rubric

from agents.errors import GradeError
from agents.lab.commands.grade import folder as command
from agents.lab.commands.grade.folder import grade_folder
from agents.lab.grading.grades import load_days
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.sandbox import SameProcess
from agents.lab.grading.students import finder_of, students_in
from agents.lab.grading.submissions import Submission, Unusable, in_folder


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Grade in this process, for speed."""

    def graded(*values: Any, **named: Any) -> Any:
        with monkeypatch.context() as context:
            context.delitem(sys.modules, "helper", raising=False)
            return grade(*values, **named, make_runner=SameProcess)

    monkeypatch.setattr(command, "Processes", Here)
    monkeypatch.setattr(command, "grade", graded)


@pytest.mark.parametrize("system", SYSTEMS)
def test_each_student_of_a_class_has_one_row_with_the_right_points(
    tmp_path: Path, system: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.lab.grading.submissions.MAX_FILES", 30)
    folder, table = tmp_path / "all", tmp_path / "grades.csv"
    rubric = load_rubric(write_rubric(tmp_path, DOUBLE))
    expected = write_class(folder, system)
    late = {each.late_name: each.days for each in expected if each.days}
    rows = grade_folder(folder, None, rubric, table, None, None, 1, late)
    assert len(rows) == len(expected) == 30
    owners = {entry: each.name for each in in_folder(folder, None) for entry in each.entries}
    find = finder_of(owners)
    for each in expected:
        row = rows[owners[find(each.late_name) or ""]]
        assert (float(row["points"]), row["late"]) == (each.points, str(each.days)), row
        assert row["points"] != "0" or row["failure"]
    out = capsys.readouterr().out
    assert "not submissions: .DS_Store, Thumbs.db, __MACOSX, c.csv" in out
    grade_folder(folder, None, rubric, table, None, None, 1, late)
    assert "saved" in capsys.readouterr().out


def entry(folder: Path, name: str, text: str = "") -> None:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text, encoding="utf-8")


def found_in(folder: Path) -> dict[str, str]:
    """Return the reason, or the file of the agent in its copy, of each student in a folder."""
    return {
        each.name: each.reason if isinstance(each, Unusable) else f"{each.module}, {each.kind}"
        for each in in_folder(folder, None)
    }


def test_what_belongs_to_a_student_is_found_by_the_number(tmp_path: Path) -> None:
    for name in (
        "Zo\u00eb_7_assignsubmission_file_/agent.py",
        "Zoe\u0308_7_assignsubmission_onlinetext_/a.html",
        "annlee_LATE_7_12_helper.py", "annlee_7_13_robot.ipynb", "annlee_8_13_robot.py",
        "annlee_7_link.html",
        "Lab 1_bob_attempt_2026-11-27-10-00-00.txt",
        "Lab 1_bob_attempt_2026-11-27-10-00-00_agent.py",
        "Lab 1_bob_attempt_2026-11-28-10-00-00_mine.py",
        "Lab 1_bob_attempt_2026-11-28-10-00-00.txt",
        "x_1_assignsubmission_file_agent.py", "x_1_assignsubmission_onlinetext_/agent.py",
    ):  # fmt: skip
        entry(tmp_path, name)
    assert found_in(tmp_path) == {
        "Zo\u00eb_7_assignsubmission_file_": "agent, None",
        "annlee_LATE_7_12_helper.py": "helper, None",
        "annlee_8_13_robot.py": "annlee_8_13_robot, None",
        "Lab 1_bob_attempt_2026-11-28-10-00-00_mine.py": "mine, None",
        "x_1_assignsubmission_file_agent.py": "two of its files are called agent.py",
    }


def test_a_folder_that_only_looks_like_one_from_canvas_has_a_student_for_each_file(
    tmp_path: Path,
) -> None:
    for name in ("lab_3_1_ann.py", "lab_3_2_bob.py"):
        entry(tmp_path, name)
    assert list(found_in(tmp_path)) == ["lab_3_1_ann.py", "lab_3_2_bob.py"]
    entry(tmp_path, "lab_3_3_agent.py")
    assert list(found_in(tmp_path)) == ["lab_3_3_agent.py"]


def test_tables_and_pages_are_no_submissions_and_all_else_is(tmp_path: Path) -> None:
    for name in ("ann.py", "ann.py.html", "ann.py.json", "data.CSV", "bob.txt", "sweep/index.html",
                 "sweep/agent.py", "pages/index.html", "pages/x.html"):  # fmt: skip
        entry(tmp_path, name)
    (tmp_path / "link").symlink_to("ann.py")
    students, phantoms = students_in(tmp_path)
    assert phantoms == ["ann.py.html", "ann.py.json", "data.CSV", "pages"]
    assert [given for [(_, given)] in students] == ["ann.py", "bob.txt", "link", "sweep"]


def test_names_are_compared_without_case_and_in_any_form_of_unicode(tmp_path: Path) -> None:
    find = finder_of(["Ann", "ann", "ZO\u00cb", "bob"])
    assert [find(name) for name in ("ann", "ANN", "zoe\u0308", "Bob", "x")] == [
        "ann", None, "ZO\u00cb", "bob", None,
    ]  # fmt: skip


def test_a_student_is_as_late_as_the_latest_part(tmp_path: Path) -> None:
    rubric = load_rubric(write_rubric(tmp_path, DOUBLE))
    for name in ("ann_7_1_agent.py", "ann_7_2_b.txt", "bob_8_3_agent.py"):
        entry(tmp_path / "all", name, "def double(x): return 2 * x\n")
    late = {"ann_7_1_agent.py": 1, "ANN_7_2_b.txt": 3}
    table = tmp_path / "grades.csv"
    rows = grade_folder(tmp_path / "all", None, rubric, table, None, None, 1, late)
    assert {name: row["points"] for name, row in rows.items()} == {
        "ann_7_1_agent.py": "7", "bob_8_3_agent.py": "10",
    }  # fmt: skip
    with pytest.raises(GradeError, match="--late names 'cecil'"):
        grade_folder(tmp_path / "all", None, rubric, table, None, None, 1, {"cecil": 1})


def test_all_files_of_a_student_are_in_one_copy_under_their_own_names(tmp_path: Path) -> None:
    for name, text in {
        "ann_7_1_agent-2.py": "1",
        "ann_7_2_zoe\u0308.PY": "2",
        "ann_7_3_data.txt": "3",
    }.items():
        entry(tmp_path, name, text)
    [submission] = in_folder(tmp_path, None)
    assert isinstance(submission, Submission)
    assert submission.shown == str(tmp_path / "ann_7_1_agent-2.py")
    with submission.private(None) as own:
        assert own.folder is not None
        texts = {path.name: path.read_text() for path in own.folder.iterdir()}
        assert own.file == own.folder / "agent.py"
    assert texts == {"agent.py": "1", "zo\u00eb.py": "2", "data.txt": "3"}


def test_libraries_are_not_part_of_a_submission(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("agents.lab.grading.submissions.MAX_FILES", 3)
    names = ("agent.py", "own/__init__.py", "own/x.txt")
    for name in (*names, "venv/lib/y.py", ".git/z.py", "own/__pycache__/a.pyc"):
        entry(tmp_path / "all" / "ann", name)
    [submission] = in_folder(tmp_path / "all", None)
    assert isinstance(submission, Submission)
    assert {place.as_posix() for _, place in submission.files} == {*names}
    entry(tmp_path / "all" / "ann", "more.txt")
    [unusable] = in_folder(tmp_path / "all", None)
    assert isinstance(unusable, Unusable)
    assert unusable.reason == "it has more than 3 files or 256 MiB"


def test_grading_resumes_from_a_table_that_a_spreadsheet_has_saved(tmp_path, capsys) -> None:
    rubric, table = load_rubric(write_rubric(tmp_path, DOUBLE)), tmp_path / "grades.csv"
    good = "def double(x): return 2 * x"
    for name, text in {"Zo\u00eb.py": good, "0042.py": "x", "b.py": ""}.items():
        entry(tmp_path / "all", name, text)
    (tmp_path / "late.csv").write_text("submission,days\nb.py,2\n0042.py,0\n")
    save_again(tmp_path / "late.csv", "decimal commas")
    late = load_days(tmp_path / "late.csv")
    assert late == {"b.py": 2, "0042.py": 0}
    before = grade_folder(tmp_path / "all", None, rubric, table, None, None, 1, late)
    written = table.read_bytes()
    save_again(table, "empty columns and rows")
    assert grade_folder(tmp_path / "all", None, rubric, table, None, None, 1, late) == before
    assert "0 graded, 1 unchanged, 2 that cannot be graded" in capsys.readouterr().out
    assert table.read_bytes() == written
