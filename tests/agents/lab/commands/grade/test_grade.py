"""The command ``warehouse grade``."""

import csv
import json
import re
import signal
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path
from time import sleep

import pytest
from helpers.command_line import ROOT, Refused, Warehouse, heed_interrupts
from helpers.documents import executable_nodes
from helpers.executors import Here
from helpers.submissions import GOOD, RUBRIC, idle, running_in, write_rubric, write_submissions

from agents.errors import WorkerError
from agents.lab.commands.grade import folder
from agents.lab.commands.grade.folder import _is_done, _row
from agents.lab.grading.grades import GradeRow
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import MINI_LAB, load_rubric
from agents.lab.grading.submissions import find_submission

ALLOWED = {"visible", "hidden", "after_due_date", "after_published"}
REPLAY = re.compile(r"^ +worst +(.*)\n +replay +(.*)$", flags=re.MULTILINE)
WORSE = (
    "class Agent:\n    def reset(self):\n        pass\n    def act(self, o):\n        return 'E'\n"
)


@pytest.fixture
def rubric(tmp_path: Path) -> Path:
    return write_rubric(tmp_path)


def rows_of(path: str) -> dict[str, dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return {row["submission"]: row for row in csv.DictReader(file)}


def test_each_replay_of_a_worst_case_shows_what_the_report_says(warehouse: Warehouse) -> None:
    """On the default layout, another one, random ones, and for an agent that fails."""
    text = RUBRIC.replace("visible = false", "").replace("first_seed = 77123", "battery = 50")
    write_rubric(
        Path(), text.replace('"closed"\nepisodes = 2', '"closed"\nepisodes = 2\nstart = [1, 1]')
    )
    source = """
import random
class Mine:
    def __init__(self, seed):
        self.seed = seed
    def reset(self):
        self.steps = 0
    def act(self, observation):
        self.steps += 1
        if self.steps == 30 and self.seed == 2:
            raise ValueError("thirty")
        return random.choice("NESW") if observation["has_item"] or random.random() < 0.8 else "PICK"
"""
    Path("mine.py").write_text(source, encoding="utf-8")
    for name in ("loops", "unseen", "chapter"):
        one = Path("rubric.toml").read_text(encoding="utf-8")
        Path("one.toml").write_text(
            one.replace('cases = ["chapter", "loops", "unseen"]', f'cases = ["{name}"]'),
            encoding="utf-8",
        )
        out = warehouse("grade", "--trust", "mine.py", "--rubric", "one.toml").out
        found = REPLAY.findall(out)
        assert len(found) >= 3
        for worst, line in found:
            shown = ""
            for part in line.split(" && "):
                words = part.split()
                assert words.pop(0) == "warehouse"
                result = warehouse(*words, *(["--no-show"] if words[0] == "run" else []))
                shown += " ".join((result.out + result.err).split())
            evidence = worst.rpartition(": ")[2].partition(";")[0].partition(" (")[0]
            assert evidence in shown, (worst, line, shown)


def test_results_have_the_form_that_gradescope_reads(warehouse: Warehouse, rubric: Path) -> None:
    """The form is documented at gradescope-autograders.readthedocs.io/en/latest/specs."""
    rubric.write_text(
        rubric.read_text().replace("points = 20\n", 'points = 20\nvisibility = "after_due_date"\n')
    )
    [file] = write_submissions(Path(), "none_without_path")
    code, out, _ = warehouse(
        "grade", "--trust", f"{file}:Agent", "--rubric", rubric, "--save", "results.json"
    )
    assert code == 0
    results = json.loads(Path("results.json").read_text(encoding="utf-8"))
    assert results["score"] == 70 == sum(test["score"] for test in results["tests"])
    assert results["visibility"] in ALLOWED
    assert results["stdout_visibility"] in ALLOWED
    assert [test["visibility"] for test in results["tests"]][1] == "after_due_date"
    for test in results["tests"]:
        assert test.keys() == {
            "name", "number", "score", "max_score", "status", "output", "visibility",
        }  # fmt: skip
        assert (test["status"] == "passed") == (test["score"] == test["max_score"])
        assert all(line.split(": ", 1)[1] in out for line in test["output"].splitlines())
    assert "time" not in results


def test_the_page_loads_nothing_and_escapes_what_agents_say(warehouse, rubric) -> None:
    [file] = write_submissions(Path(), "raises_markup")
    saved = [*("--save", "report.html"), *("--save", "report.json")]
    out = warehouse("grade", "--trust", file, "--rubric", rubric, *saved).out
    page = Path("report.html").read_text(encoding="utf-8")
    assert executable_nodes(Path("report.html")) == []
    assert "&lt;script&gt;alert(1)" in page
    assert "\x1b" not in page + out + Path("report.json").read_text(encoding="utf-8")
    assert "http" not in page.replace("http-equiv", "")


def test_a_folder_is_graded_once_and_again_where_something_has_changed(
    warehouse: Warehouse, rubric: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_submissions(Path("all"), "searches", "picks", "syntax")
    Path("all", "=cmd.py").write_text(idle("pass"), encoding="utf-8")
    Path("all", "none").mkdir()
    words = ("grade", "--trust", "all", "--rubric", rubric, "-o", "grades.csv", "--jobs", 1)
    result = warehouse(*words, "--jobs", 2, "--pages", "pages")
    assert result.code == 0
    assert "3 graded, 0 unchanged, 2 that cannot" in result.out
    _, *lines = result.out.splitlines()
    place = lines.index("  1  delivers, up to 60 points")
    assert max(map(len, lines[:place])) <= 80
    assert lines[place + 1] == "  2  stays calm, up to 20 points"
    assert "none: it has no .py, .ipynb or .zip file" in lines
    assert any(each.startswith("syntax: cannot be loaded: SyntaxError") for each in lines)
    assert "mean 20.0, median 0; all points: 1, no points: 4" in lines
    assert any(each.startswith("most often missed: 'delivers' (4 of 5 sub") for each in lines)
    rows, first = rows_of("grades.csv"), Path("grades.csv").read_bytes()
    points = {name: row["points"] for name, row in rows.items()}
    assert points == {"searches": "100", "picks": "0", "syntax": "0", "none": "0", "'=cmd.py": "0"}
    assert rows["syntax"]["failure"].startswith("cannot be loaded: SyntaxError")
    assert rows["none"]["failure"] == "it has no .py, .ipynb or .zip file"
    assert len(list(Path("pages").iterdir())) == 9
    monkeypatch.setattr(folder, "Processes", Here)  # for speed
    assert "0 graded, 3 unchanged, 2 that cannot" in warehouse(*words).out
    assert Path("grades.csv").read_bytes() == first
    Path("all", "picks", "agent.py").write_text(GOOD, encoding="utf-8")
    assert "1 graded, 2 unchanged, 2 that cannot" in warehouse(*words).out
    assert rows_of("grades.csv")["picks"]["points"] == "100"
    rubric.write_text(RUBRIC.replace("points = 20", "points = 10"), encoding="utf-8")
    assert "3 graded, 0 unchanged, 2 that cannot" in warehouse(*words).out
    assert rows_of("grades.csv")["searches"]["points"] == "90"


def test_an_agent_that_ended_the_grader_has_no_points(rubric: Path) -> None:
    """Compiled code can do this on systems that cannot keep agents from other processes."""
    future: Future[GradeRow] = Future()
    future.set_exception(WorkerError("its process was ended by signal 9"))
    file = Path("agent.py")
    file.write_text(GOOD, encoding="utf-8")
    submission, asked = find_submission(str(file)), load_rubric(rubric)
    row = _row(future, submission, asked)
    assert row["points"] == "0"
    assert row["failure"] == "it ended the grader: its process was ended by signal 9"
    assert _is_done(submission, row, asked)
    assert not _is_done(submission._replace(late=1), row, asked)
    del row["stays calm"]  # a criterion
    assert not _is_done(submission, row, asked)


def test_an_interrupted_folder_is_resumed_and_nothing_is_left_running(
    warehouse: Warehouse, rubric: Path, tmp_path: Path
) -> None:
    rubric.write_text(RUBRIC.replace("give_up_after = 1", "give_up_after = 99"), encoding="utf-8")
    write_submissions(tmp_path / "all", "searches", "sleeps")
    words = [
        "grade",
        "--trust",
        "all",
        "--rubric",
        "rubric.toml",
        "-o",
        "grades.csv",
        "--jobs",
        "1",
    ]
    code, copies = "from agents.__main__ import main; main()", tmp_path / "copies"
    copies.mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", code, *words],
        cwd=tmp_path,
        env={"PYTHONPATH": str(ROOT), "PATH": "", "TMPDIR": str(copies)},
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    ) as process:
        while not Path("grades.csv").exists() or "searches" not in rows_of("grades.csv"):
            assert process.poll() is None
            sleep(0.05)
        while not running_in(copies):
            assert process.poll() is None
            sleep(0.01)
        process.send_signal(signal.SIGINT)
        told, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (130, "warehouse: interrupted\n")
    assert "1 of 2 submissions are in grades.csv; run the same command again to resume" in told
    assert list(rows_of("grades.csv")) == ["searches"]
    assert not running_in(copies)
    assert not list(copies.iterdir())
    Path("all", "sleeps", "agent.py").write_text(WORSE, encoding="utf-8")
    assert "1 graded, 1 unchanged, 0 that cannot" in warehouse(*words).out
    assert list(rows_of("grades.csv")) == ["searches", "sleeps"]


def test_another_table_is_not_written_over(refused: Refused) -> None:
    write_submissions(Path("all"), "searches")
    Path("other.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    said = refused("grade", "--trust", "all", "-o", "other.csv")
    assert said.startswith("other.csv: not a table of grades")
    assert Path("other.csv").read_text(encoding="utf-8") == "a,b\n1,2\n"


def test_the_files_of_a_class_are_written_and_not_written_over(warehouse, refused, rubric) -> None:
    out = warehouse("grade", "--write", "my_agent.py").out
    assert out == "saved my_agent.py; to grade it: warehouse grade my_agent.py\n"
    report = grade(find_submission("my_agent.py"), load_rubric(MINI_LAB))
    assert not report.failure
    assert 0 < report.points < 40
    Path("my_agent.py").write_text("mine", encoding="utf-8")
    assert "not overwritten" in refused("grade", "--write", "my_agent.py")
    assert Path("my_agent.py").read_text(encoding="utf-8") == "mine"
    words = "grade", "--rubric", rubric, "--write", "start.py"
    assert refused(*words) == f"{rubric}: there is no starting file rubric.py next to it"
    rubric.with_suffix(".py").write_text(GOOD, encoding="utf-8")
    assert f"warehouse grade start.py --rubric {rubric}" in warehouse(*words).out
    assert Path("start.py").read_text(encoding="utf-8") == GOOD
    out = warehouse("grade", "--write", "mine.toml").out
    assert out == "saved mine.toml; to use it: warehouse grade my_agent.py --rubric mine.toml\n"
    assert Path("mine.toml").read_bytes() == MINI_LAB.read_bytes()
    assert warehouse("grade", "--write", "a.zip").out == "saved a.zip\n"
    assert Path("a.zip").stat().st_size > 100_000


LATER = RUBRIC.replace("points = 20\n", 'points = 20\nvisibility = "after_due_date"\n').replace(
    "[limits]", "[late]\npoints = 5\n[limits]"
)


def test_pages_show_what_is_visible_by_then_in_one_file_each(
    warehouse: Warehouse, rubric: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder, "Processes", Here)
    rubric.write_text(LATER)
    write_submissions(Path("all"), "none_without_path")
    Path("all", "<b>").mkdir()
    Path("all", "<b>", "agent.py").write_text("", encoding="utf-8")
    Path("late.csv").write_text("submission,days\nnone_without_path,2\n")
    words = ("grade", "--trust", "all", "--rubric", rubric, "--jobs", 1, "--pages", "pages",
             "--late", "late.csv")  # fmt: skip
    warehouse(*words)
    assert rows_of("grades.csv")["none_without_path"]["points"] == "60"
    page, results = (Path("pages", f"none_without_path{end}") for end in (".html", ".json"))
    text, found = page.read_text(encoding="utf-8"), json.loads(results.read_text())
    assert [test["name"] for test in found["tests"]] == ["delivers", "protocol", "fewest"]
    assert "60 of 80 points" in text
    assert "2 days late: 10 points deducted" in text
    assert "20 more points are not shown yet" in text
    assert "stays calm" not in text
    assert "<iframe" in text, "the worst episode plays"
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    index = Path("pages", "index.html").read_text(encoding="utf-8")
    assert 'href="./none_without_path.html"' in index
    assert "<b>" not in index
    assert "0 graded, 1 unchanged, 1 that cannot" in warehouse(*words).out
    page.unlink()
    assert "1 graded, 0 unchanged, 1 that cannot" in warehouse(*words).out
    assert page.exists()


def test_the_name_of_the_index_is_refused(refused, rubric) -> None:
    Path("all", "index").mkdir(parents=True)
    said = refused("grade", "--trust", "all", "--rubric", rubric)
    assert said.startswith("all/index: no submission may have the name of the page")


def test_tables_for_others_are_saved_and_agents_have_a_class(warehouse, rubric) -> None:
    Path("all").mkdir()
    Path("all", "ann.py").write_text(GOOD, encoding="utf-8")
    words = ("grade", "--trust", "all:Mine", "--rubric", rubric, "--jobs", 1)
    out = warehouse(*words, "--moodle", "m.csv", "--canvas", "c.csv").out
    assert "saved m.csv\nsaved c.csv\n" in out
    assert "ann.py: cannot be loaded: AttributeError: there is no class Mine" in out
    assert "ann,,0,100" in Path("m.csv").read_text()
    assert ",,,ann,,0" in Path("c.csv").read_text()
