"""The autograder for Gradescope, in a folder with the layout of Gradescope's containers."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from helpers.submissions import GOOD, RUBRIC, idle, notebook_of, write_rubric

from agents.errors import GradeError
from agents.lab.grading import gradescope
from agents.lab.grading.gradescope import ENDED, days_late, write_autograder
from agents.lab.grading.rubric import load_rubric

SHORT = RUBRIC.replace("[limits]", "[late]\npoints = 10\n[limits]").replace(
    'layout = "trap"', 'layout = "halls/hall.txt"'
)
METADATA = {
    "created_at": "2026-11-24T00:05:01.5-07:00",
    "assignment": {"due_date": "2026-11-22T00:00:00.0-07:00"},
}


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an archive unpacked as on Gradescope."""
    folder = tmp_path_factory.mktemp("autograder")
    (folder / "halls").mkdir()
    (folder / "halls" / "hall.txt").write_text("P....\n.....\n....D\n")
    rubric = load_rubric(write_rubric(folder, SHORT))
    archives = [folder / name for name in ("one.zip", "other.zip")]
    for archive in archives:
        write_autograder(archive, rubric)
    assert archives[0].read_bytes() == archives[1].read_bytes()
    with ZipFile(archives[0]) as opened:
        opened.extractall(folder / "source")
        assert opened.getinfo("run_autograder").external_attr >> 16 == 0o100755
    return folder


def results(root: Path, python: str = sys.executable) -> Any:
    """Return the results that the autograder's copy of this program writes for the submission."""
    variables = {"AUTOGRADER_ROOT": str(root), "AUTOGRADER_PYTHON": python, "PATH": os.defpath}
    done = subprocess.run(
        ["bash", root / "source" / "run_autograder"],
        env=variables, cwd="/", check=False, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads((root / "results" / "results.json").read_text(encoding="utf-8"))


def submit(root: Path, **files: str) -> None:
    for path in (root / "submission").glob("*"):
        path.unlink()
    (root / "submission").mkdir(exist_ok=True)
    for name, text in files.items():
        (root / "submission" / name.replace("_", ".")).write_text(text, encoding="utf-8")


def test_what_it_needs_is_pinned(root: Path) -> None:
    lines = (root / "source" / "requirements.txt").read_text().splitlines()
    assert "numpy" in {line.partition("==")[0] for line in lines}
    assert all(line.partition("==")[2][0].isdigit() for line in lines)


def test_submissions_have_results_whatever_happens(root: Path) -> None:
    submit(root, hw_ipynb=notebook_of(GOOD))
    (root / "submission_metadata.json").write_text(json.dumps(METADATA))
    found = results(root)
    assert (found["score"], found["extra_data"]["agent"]) == (70, "hw.ipynb:Agent")
    assert "3 days late: 30 points deducted" in found["output"]
    (root / "submission_metadata.json").unlink()
    assert results(root)["output"].endswith(f"{AS_ASKED}No such file or directory")
    submit(root, agent_py=idle("exit(1)"))
    assert "no points: 10 of 10 episodes failed" in results(root)["output"]
    submit(root, notes_txt="")
    found = results(root)
    said = "This submission cannot be graded: it has no .py, .ipynb or .zip file"
    assert (found["score"], found["output"]) == (0, said)
    assert results(root, "/bin/false")["output"] == ENDED
    rubric = root / "source" / "rubric.toml"
    text = rubric.read_text()
    rubric.write_text("[")
    assert results(root)["output"].startswith("This submission cannot be graded: ")
    rubric.write_text(text)


EXTENDED = {"assignment": {"due_date": "2026-11-23T23:00:00-07:00"}}
AS_ASKED = "counted as on time, because submission_metadata.json is not as expected: "


@pytest.mark.parametrize(
    ("changes", "days", "note"),
    [
        ({}, 3, ""),
        ({"created_at": "2026-11-22T00:00:00-07:00"}, 0, ""),
        ({"created_at": "2026-11-22T00:00:00.5-07:00"}, 0, ""),
        ({"created_at": "2026-11-22T07:05:00Z"}, 0, ""),
        ({"created_at": "2026-11-22T07:05:01Z"}, 1, ""),
        ({"created_at": "2026-11-23T07:05:01Z"}, 2, ""),
        ({"users": [{"assignment": {"due_date": "2026-11-25T00:00:00-07:00"}}]}, 0, ""),
        ({"users": [EXTENDED]}, 1, ""),
        ({"users": [EXTENDED, {"assignment": METADATA["assignment"]}]}, 1, ""),
        ({"users": [{"assignment": {"due_date": None}}, {"assignment": None}, {}]}, 3, ""),
        ({"assignment": {"due_date": None}}, 0, ""),
        ({"created_at": "2026-11-24T00:00:00"}, 0,
         AS_ASKED + "the time '2026-11-24T00:00:00' has no time zone"),
        ({"assignment": None}, 0, AS_ASKED + "it has no time of the submission or no due date"),
        ({"users": 1}, 0, AS_ASKED + "it has no time of the submission or no due date"),
    ],
)  # fmt: skip
def test_a_day_that_has_begun_is_late_after_the_grace_period(tmp_path, changes, days, note) -> None:
    (tmp_path / "submission_metadata.json").write_text(json.dumps(METADATA | changes))
    assert days_late(tmp_path, 5) == (days, note)


def test_metadata_that_cannot_be_read_count_as_on_time_with_a_remark(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(gradescope, "MAX_METADATA", 200_000)
    assert days_late(tmp_path, 5) == (0, f"{AS_ASKED}No such file or directory")
    for text, reason in {"[" * 100_000: "recursion", " " * 200_001: "it is longer than"}.items():
        (tmp_path / "submission_metadata.json").write_text(text)
        days, note = days_late(tmp_path, 5)
        assert days == 0
        assert note.startswith(AS_ASKED)
        assert reason in note


def test_a_layout_that_is_not_next_to_the_rubric_is_refused(tmp_path: Path) -> None:
    (tmp_path / "hall.txt").write_text("P...D\n")
    (tmp_path / "inner").mkdir()
    text = RUBRIC.replace('layout = "trap"', 'layout = "../hall.txt"')
    rubric = load_rubric(write_rubric(tmp_path / "inner", text))
    with pytest.raises(GradeError, match="must be in the folder of the rubric"):
        write_autograder(tmp_path / "a.zip", rubric)
    assert not (tmp_path / "a.zip").exists()
