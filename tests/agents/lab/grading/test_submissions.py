"""Good, bad and hostile agents get the points they deserve, and leave nothing behind."""

import ast
import json
import os
import re
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest
from helpers.attacks import BEFORE, DEEDS, attempt
from helpers.submissions import (
    GOOD,
    RUBRIC,
    SUBMISSIONS,
    Expected,
    good,
    idle,
    notebook_of,
    nothing_left_in,
    write_rubric,
)

from agents.errors import AgentError, GradeError
from agents.lab.grading import sandbox, submissions, walls
from agents.lab.grading.grades import row_of
from agents.lab.grading.gradescope import results_of
from agents.lab.grading.grading import GradeReport, grade
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.sandbox import agents_user, check_trust, most_jobs
from agents.lab.grading.submissions import Submission, Unusable, find_submission, in_folder

NOBODY = 65534


SLOWEST = ("sleeps", "leaves_a_daemon", "prints_much", "answers_much")
"""Agents similar to others, which default tests skip because together they take long."""

HIDDEN = re.sub(
    "max_steps.*", "max_steps = 60\nvisible = false", RUBRIC.replace("visible = false", "")
)
"""The rubric without visible episodes."""


as_root = pytest.mark.skipif(os.getuid() != 0, reason="only root may run agents as another user")


@pytest.fixture
def no_walls(monkeypatch: pytest.MonkeyPatch) -> None:
    """A system without walls around agents."""
    monkeypatch.setattr(walls, "enforced", frozenset)


@pytest.fixture(autouse=True)
def copies(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the folder of private copies; no copy and no process may be left in it."""
    folder = tmp_path_factory.mktemp("copies")
    with nothing_left_in(folder):
        yield folder


def grade_source(
    folder: Path, source: str, rubric: str = RUBRIC, user: str | None = None
) -> GradeReport:
    file = folder / "agent.py"
    file.write_text(source, encoding="utf-8")
    return grade(find_submission(str(file)), load_rubric(write_rubric(folder, rubric)), user)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        pytest.param(*each, id=each[0], marks=[pytest.mark.slow] * (each[0] in SLOWEST))
        for each in SUBMISSIONS.items()
    ],
)
def test_agents_get_what_they_have_earned_and_leave_nothing_behind(
    tmp_path: Path, name: str, expected: Expected
) -> None:
    (tmp_path / name).mkdir()
    report = grade_source(tmp_path / name, expected.source)
    said = report.failure or " ".join(each.worst for each in report.grades)
    assert (report.points, bool(report.failure)) == (expected.points, not expected.is_loaded), said
    assert expected.failure in said
    assert "LookupError" not in said, "it has found something in its memory"
    assert {path.name for path in (tmp_path / name).iterdir()} == {"agent.py", "rubric.toml"}


@pytest.mark.parametrize(("error", "told"), [("ValueError", "ValueError"), ("Own", "an exception")])
def test_hidden_episodes_stay_hidden(tmp_path: Path, error: str, told: str) -> None:
    """Reports contain no words of the agent about them, and the agent does not know their seeds."""
    body = f"raise {error}(observation, self.seed)"
    source = f"""
class Own(Exception):
    pass
class Agent:
    def __init__(self, seed):
        self.seed = seed
        assert seed < 4
    def reset(self):
        pass
    def act(self, observation):
        {body}
"""
    report = grade_source(tmp_path, source, HIDDEN)
    assert {(each.worst, each.command) for each in report.grades} == {
        (f"fails: {told} (a hidden episode)", "")
    }
    text = json.dumps(results_of(report))
    assert not re.search("7712|robot_pos|--seed", text)


def test_the_answers_of_an_episode_have_a_limit_together(tmp_path: Path) -> None:
    """Otherwise an agent could use the limit of one answer 60 times."""
    rubric = RUBRIC.replace("episode_seconds = 3.0", "episode_seconds = 0.5")
    report = grade_source(tmp_path, idle("time.sleep(0.2)", "import time"), rubric)
    assert report.grades[0].worst.endswith("its answers took 0.5 s in all")


@pytest.mark.parametrize("user", [None, pytest.param("nobody", marks=as_root)])
def test_the_kernel_refuses_what_is_outside_of_an_agent(tmp_path: Path, user: str | None) -> None:
    """``bench_grade.py`` tries each attack alone, also while an agent is loaded and acts."""
    tmp_path.chmod(0o700)  # the user of agents reads them all the same
    body = "\n".join(map(attempt, DEEDS.values()))
    (tmp_path / "rubric.toml").write_text("hidden")
    (tmp_path / "mine").mkdir()
    report = grade_source(tmp_path / "mine", good("begin(self)", body, BEFORE), user=user)
    assert report.points == 100, report.grades
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {"agent.py", "rubric.toml"}


def test_an_agent_that_passes_by_the_rules_of_python_is_ended_with_all_it_has_started(
    tmp_path: Path, no_walls: None
) -> None:
    """``daemon`` of C leaves a process that is neither a child of the agent nor in its session."""
    body = (
        f"os.chdir({str(tmp_path)!r})\n"
        "for name in os.listdir():\n"
        "    if name.isdigit() and os.path.exists('/proc/' + name):\n"
        "        open('alive', 'w').close()\n"
        "        return 'WAIT'\n"
        "libc = ctypes.CDLL(None)\n"
        "libc.daemon(1, 1)\n"
        "open(str(os.getpid()), 'w').close()\n"
        "libc.sleep(600)"
    )
    rubric = RUBRIC.replace("give_up_after = 1", "give_up_after = 2")
    report = grade_source(tmp_path, idle(body, "import ctypes, os"), rubric)
    assert not (tmp_path / "alive").exists(), "it was there in the next episode"
    started = [path.name for path in tmp_path.iterdir() if path.name.isdigit()]
    assert started
    assert not any(Path("/proc", each).exists() for each in started)
    assert report.points == 0


@pytest.mark.parametrize(
    ("number", "before", "found"),
    [
        (signal.SIGKILL, "", "ends its process"),
        (signal.SIGSTOP, "", "takes too long"),
        (signal.SIGKILL, "libc.daemon(1, 1)", "takes too long"),
    ],
)
def test_an_agent_that_ends_or_stops_what_has_started_it_ends_no_other_episode(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    no_walls: None,
    number: int,
    before: str,
    found: str,
) -> None:
    """Compiled code can send signals. In that case the next episode gets a new server.

    What is a daemon by then is nobody's but the grader's, which ends it.
    """
    monkeypatch.setattr(sandbox, "ENDING_SECONDS", 0.3)
    body = (
        f"os.chdir({str(tmp_path)!r})\n"
        "if observation['steps'] == 2 and not os.path.exists('done'):\n"
        "    open('done', 'w').close()\n"
        "    libc = ctypes.CDLL(None)\n"
        f"    {before}\n"
        f"    libc.sigqueue(os.getppid(), {number:d}, 0)\n"
        "    libc.sleep(600)"
    )
    source = good("before(self, observation)", body, "import ctypes, os")
    rubric = RUBRIC.replace("give_up_after = 1", "give_up_after = 2")
    report = grade_source(tmp_path, source, rubric)
    assert report.grades[0].seen == f"88% of 8 episodes: 7 delivered and 1 {found}"


REMEMBERS = """
import os
class Agent:
    def reset(self):
        places = [os.path.dirname(os.path.abspath(__file__)), os.path.abspath(__file__)]
        places += [os.path.join(places[0], name) for name in ("data.txt", "link.txt")]
        dates = [(os.lstat(each).st_atime_ns, os.lstat(each).st_mtime_ns) for each in places]
        assert set(dates) == {((2**31 - 1) * 10**9, 0)}, dates
        names = sorted(os.listdir(places[0]))
        assert names == ["agent.py", "data.txt", "link.txt"], names
        os.readlink(places[3])
        for place in places[1:]:
            open(place).read()
    def act(self, observation):
        return "WAIT"
"""


def test_reading_its_files_leaves_no_sign_for_the_next_process_of_an_agent(tmp_path: Path) -> None:
    """Files from the future would have a new date of access after the first reading."""
    for folder in (tmp_path / "alone", tmp_path / "class" / "ann"):
        folder.mkdir(parents=True)
        (folder / "agent.py").write_text(REMEMBERS)
        (folder / "data.txt").write_text("42")
        (folder / "link.txt").symlink_to("data.txt")
        for path in (folder / "agent.py", folder / "data.txt", folder):
            os.utime(path, (4e9, 4e9))
    (tmp_path / "class" / "bob.py").write_text("")
    rubric = load_rubric(write_rubric(tmp_path / "alone"))
    [ann, _] = in_folder(tmp_path / "class", None)
    assert isinstance(ann, Submission)
    for submission in (ann, find_submission(str(tmp_path / "alone" / "agent.py"))):
        report = grade(submission, rubric)
        assert report.reason.endswith("8 ineffective and 2 unreachable"), report.remarks


def test_only_the_code_of_a_large_folder_is_copied_for_one_of_its_files(tmp_path, monkeypatch):
    monkeypatch.setattr(submissions, "MAX_FILES", 2)
    for name in ("agent.py", "helper.py", "notes.txt"):
        (tmp_path / name).touch()
    submission = find_submission(str(tmp_path / "agent.py"))
    assert {place.as_posix() for _, place in submission.files} == {"agent.py", "helper.py"}


@as_root
def test_agents_can_run_as_another_user(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = Path(os.path.realpath("/tmp"), f"graded-{os.getpid()}")
    folder.mkdir(mode=0o755)
    try:
        secret = folder / "secret"
        secret.write_text("seeds", encoding="utf-8")
        secret.chmod(0o600)
        (folder / "mine").mkdir()
        body = (
            f"assert os.getuid() == {NOBODY} and not os.getgroups()\n"
            f"try: open({str(secret)!r})\n"
            "except PermissionError: return\n"
            "raise AssertionError('it can read private files')"
        )
        source = good("begin(self)", body, "import os")
        report = grade_source(folder / "mine", source, user="nobody")
        assert report.points == 100, report.grades
        with pytest.raises(GradeError, match="--user no_such_user: there is no such user"):
            grade_source(folder / "mine", GOOD, user="no_such_user")
    finally:
        shutil.rmtree(folder)


def test_a_folder_has_files_and_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An entry that is not a submission gets a reason and does not stop the others."""
    monkeypatch.setattr(submissions, "MAX_BYTES", 100)
    for name in ("searches", "waits", "two: a", "zero", "folder", "folder/agent.py", "large"):
        (tmp_path / name).mkdir()
    for name in ("searches/agent.py", "waits/agent.py", "waits/other.py", "two: a/a.py",
                 "two: a/b.py", "mine.py", "notes.txt", ".x.py", "large/agent.py"):  # fmt: skip
        (tmp_path / name).touch()
    (tmp_path / "large" / "weights").write_bytes(bytes(101))
    os.mkfifo(tmp_path / "pipe.py")
    (tmp_path / "zero" / "agent.py").symlink_to("/dev/zero")
    for name, target in {"copied.py": "mine.py", "gone.py": "gone", "other": "searches"}.items():
        (tmp_path / name).symlink_to(tmp_path / target)
    found = {each.name: each for each in in_folder(tmp_path, None)}
    assert {name for name, each in found.items() if isinstance(each, Submission)} == {
        "mine.py", "searches", "waits",
    }  # fmt: skip
    assert {name: each.reason for name, each in found.items() if isinstance(each, Unusable)} == {
        "notes.txt": "it is neither a .py, .ipynb or .zip file nor a folder",
        "copied.py": "it is a link, which is not followed",
        "folder": "it has no .py, .ipynb or .zip file",
        "gone.py": "it is a link, which is not followed",
        "large": "it has more than 1,000 files or 0 MiB",
        "other": "it is a link, which is not followed",
        "pipe.py": "it is a pipe, not a file",
        "two: a": "it has 2 .py files, but none is called agent.py",
        "zero": "agent.py: it is a link, which is not followed",
    }


def test_notebooks_archives_and_nested_files_are_graded_and_leave_nothing(tmp_path: Path) -> None:
    """Agents in all forms import their own files, and unpacked files are removed."""
    before, after = GOOD.split("class Agent:")
    nested = f"import helper\nfrom helper import *\nclass Agent:{after}"
    folder, rubric = tmp_path / "all", load_rubric(write_rubric(tmp_path))
    for name, text in {
        "cells.ipynb": notebook_of("import numpy", before, f"class Agent:{after}", "1 / 0"),
        "nested/src/agent.py": nested, "nested/src/helper.py": before, "nested/notes.txt": "",
        "nested/.ipynb_checkpoints/agent.py": "", "two/a.ipynb": "", "two/b.ipynb": "",
        "twice/a/agent.py": "", "twice/b/agent.py": "", "bad.zip": "PK",
    }.items():  # fmt: skip
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "moodle").mkdir()
    for name in ("archive.zip", "moodle/any.zip"):
        with ZipFile(folder / name, "w") as archive:
            archive.writestr("ann/agent.py", nested)
            archive.writestr("ann/helper.py", before)
            archive.writestr("__MACOSX/agent.py", "")
    found, refused = {}, {}
    for each in in_folder(folder, None, [folder / "two"]):
        if isinstance(each, Unusable):
            refused[each.name] = each.reason
        else:
            found[each.name] = grade(each, rubric)
    assert {name: each.points for name, each in found.items()} == dict.fromkeys(
        ("archive.zip", "cells.ipynb", "moodle", "nested"), 100
    )
    assert found["archive.zip"].agent == "ann/agent.py:Agent"
    assert refused == {
        "bad.zip": "it cannot be unpacked: it is not a ZIP archive",
        "twice": "it has 2 .py files, but none is called agent.py",
    }


@pytest.mark.parametrize(
    ("limits", "source", "said"),
    [
        ('deny_imports = ["agents"]', "from agents.search import ExploringAgent as A",
         "ImportError: the rubric denies the import of agents.search (agent.py, line 1)"),
        ('deny_imports = ["agents"]', "import importlib\n"
         "A = importlib.import_module('agents.search').ExploringAgent",
         "ImportError: the rubric denies the import of agents.search (agent.py, line 2)"),
        ('deny_imports = ["agents"]', "import importlib._bootstrap as own\n"
         "A = own._gcd_import('agents.search').ExploringAgent",
         "PermissionError: the rubric denies the import of this module (agent.py, line 2)"),
        ('deny_imports = ["numpy.random"]', "from numpy import random",
         "ImportError: the rubric denies the import of numpy.random (agent.py, line 1)"),
        ('allow_imports = ["numpy", "math"]', "import numpy.random, math, mine, os",
         "ImportError: the rubric does not allow the import of os; allowed: numpy, math "
         "(agent.py, line 1)"),
        ('allow_imports = ["warehouse_core"]\ndeny_imports = ["numpy"]',
         f"import warehouse_core\n{GOOD}",
         "ImportError: the rubric does not allow the import of collections; "
         "allowed: warehouse_core (agent.py, line 4)"),
    ],
)  # fmt: skip
def test_a_rubric_says_what_agents_may_import(tmp_path, limits, source, said) -> None:
    (tmp_path / "mine.py").touch()
    rubric = RUBRIC.replace("give_up_after = 1", f"give_up_after = 1\n{limits}")
    report = grade_source(tmp_path, f"{source}\nclass Agent(A):\n    pass\n", rubric)
    assert report.failure == f"cannot be loaded: {said}"


def test_a_rubric_denies_our_own_agents_nothing(tmp_path: Path) -> None:
    rubric = RUBRIC.replace("give_up_after = 1", 'give_up_after = 1\ndeny_imports = ["agents"]')
    ours = find_submission("exploring")
    assert grade(ours, load_rubric(write_rubric(tmp_path, rubric))).points == 100


def test_no_points_have_a_reason(tmp_path: Path) -> None:
    for source, reason in {
        idle("1 / 0"): "no points: 10 of 10 episodes failed: it fails at step 1: "
        "ZeroDivisionError: division by zero (agent.py, line 8)",
        idle("pass"): "no points: 10 episodes, 8 ineffective and 2 unreachable",
        idle("time.sleep(9)", "import time"): "no points: 10 of 10 episodes failed: it takes too "
        "long at step 1: no answer within 0.5 s",
    }.items():
        report = grade_source(tmp_path, source)
        assert report.reason == reason
        assert row_of("ann", report)["failure"] == reason
    assert not grade_source(tmp_path, GOOD).remarks


@pytest.mark.usefixtures("no_walls")
def test_files_of_a_folder_hide_nothing_from_each_other(tmp_path: Path) -> None:
    """They hide neither modules of this program nor others."""
    (tmp_path / "all" / "own").mkdir(parents=True)
    rubric = load_rubric(write_rubric(tmp_path))
    heirs = "import numpy\nfrom agents import GreedyAgent\nclass Agent(GreedyAgent):\n    pass\n"
    for name, source in {
        "agents.py": GOOD, "numpy.py": f"import numpy\nnumpy.int64\n{GOOD}", "heir.py": heirs,
        "own/agent.py": GOOD, "own/queue.py": "",
    }.items():  # fmt: skip
        Path(tmp_path, "all", name).write_text(source, encoding="utf-8")
    reports = {each.name: grade(each, rubric) for each in in_folder(tmp_path / "all", None)}
    assert {name: each.points for name, each in reports.items()} == {
        "agents.py": 100, "heir.py": 73.22, "numpy.py": 100, "own": 100,
    }  # fmt: skip


def test_a_submission_is_parsed_in_its_own_process_alone(tmp_path, monkeypatch) -> None:
    """The syntax tree of a list of four megabytes takes two gigabytes."""
    monkeypatch.setattr(ast, "parse", lambda *_: pytest.fail("the grader parses"))
    report = grade_source(tmp_path, f"import numpy\nx = [{'0,' * 2_000_000}]\n{GOOD}")
    assert report.failure.startswith(("cannot be loaded: MemoryError", "takes too long"))


def test_a_changed_file_of_a_submission_in_a_folder_changes_its_digest(tmp_path: Path) -> None:
    (tmp_path / "all" / "mine" / "data").mkdir(parents=True)
    for name in ("agent.py", "data/weights"):
        (tmp_path / "all" / "mine" / name).touch()
    [before] = in_folder(tmp_path / "all", None)
    (tmp_path / "all" / "mine" / "data" / "weights").write_text("1")
    [after] = in_folder(tmp_path / "all", None)
    assert isinstance(before, Submission)
    assert isinstance(after, Submission)
    assert before.digest != after.digest


def test_root_leaves_agents_to_nobody_if_both_walls_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    for held, root, trusted, user, expected in (
        ({"files", "processes"}, 0, False, None, "nobody"),
        ({"files", "processes"}, 0, False, "ann", "ann"),
        ({"files", "processes"}, 0, True, None, None),
        ({"files", "processes"}, 1000, False, None, None),
        ({"processes"}, 0, False, None, None),
    ):
        monkeypatch.setattr(walls, "enforced", lambda held=held: frozenset(held))
        monkeypatch.setattr(os, "getuid", lambda root=root: root)
        assert agents_user(user, trusted) == expected


def test_who_is_not_kept_from_others_must_be_trusted(monkeypatch, no_walls: None) -> None:
    monkeypatch.setattr(os, "getuid", lambda: 1000)
    assert check_trust(None, is_trusted=False, are_many=False).startswith("agents can read files")
    with pytest.raises(
        GradeError, match=r"on this system agents can read files .* or use --trust if"
    ):
        check_trust(None, is_trusted=False, are_many=True)
    assert check_trust(None, is_trusted=True, are_many=True)
    assert most_jobs("nobody", 4) == 1 < most_jobs(None, 4)
    monkeypatch.setattr(os, "getuid", lambda: 0)
    with pytest.raises(
        GradeError, match="refusing to run student code as root; use --user nobody, or --trust"
    ):
        check_trust(None, is_trusted=False, are_many=False)
    assert check_trust("nobody", is_trusted=False, are_many=True)


def test_a_graded_agent_takes_no_arguments(tmp_path: Path) -> None:
    file = tmp_path / "a=b.py"
    file.write_text("class Mine: pass\n")
    assert find_submission(f"{file}:Mine").shown == str(file)
    with pytest.raises(AgentError, match=r"graded agents take no arguments; given: x=2$"):
        find_submission(f"{file}:Mine:x=2")
