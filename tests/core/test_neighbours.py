"""The package next to other packages, in unusual places and with options of Python."""

import subprocess
import sys
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

from warehouse_core import WarehouseEnv, record_episode
from warehouse_core.neighbours import warn_of_other_agents

ROOT = Path(__file__).parents[2]


def run(*words: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("place", ["agents.py", "agents/__init__.py"])
def test_another_module_called_agents_is_noticed(tmp_path: Path, place: str) -> None:
    (tmp_path / place).parent.mkdir(exist_ok=True)
    (tmp_path / place).write_text("class Agent: ...\n")
    result = run("-c", "import warehouse_core", folder=tmp_path)
    assert result.returncode == 0
    assert f"agents ({tmp_path / place}) is not the one of warehouse-lab" in result.stderr
    assert "virtual environment of its own" in result.stderr


@pytest.mark.filterwarnings("default")
def test_a_module_made_by_hand_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "agents", ModuleType("agents"))
    with pytest.warns(UserWarning, match=r"the module agents \(in memory\) is not the one"):
        warn_of_other_agents()


def test_no_agents_at_all_are_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_core.neighbours.find_spec", lambda name: None)
    warn_of_other_agents()


COMMANDS = ("run --seed 1 --save x.html", "grade greedy --rubric rubric.toml")
RUBRIC = """
title = "Deliver"
[cases.seen]
episodes = 2
[[criteria]]
name = "delivers"
points = 10
measure = "delivered"
cases = ["seen"]
full = 1
zero = 0
"""


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    """Return a ZIP file with the packages."""
    archive = tmp_path / "lab.zip"
    with zipfile.ZipFile(archive, "w") as packed:
        for package in ("warehouse_core", "warehouse_physics", "agents"):
            for file in (ROOT / package).rglob("*"):
                if file.is_file() and "__pycache__" not in file.parts:
                    packed.write(file, file.relative_to(ROOT))
    return archive


def test_commands_and_pages_work_from_a_zip_file(archive: Path, tmp_path: Path) -> None:
    """Commands read rubrics and parts of pages, which are files of the packages."""
    (tmp_path / "rubric.toml").write_text(RUBRIC)
    program = f"""
import sys
sys.path.insert(0, {str(archive)!r})
from agents.__main__ import main
assert ".zip" in main.__code__.co_filename
for words in {COMMANDS}:
    sys.argv[1:] = words.split()
    try:
        main()
    except SystemExit as end:
        assert not end.code, words
"""
    result = run("-c", program, folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "of 10 points" in result.stdout
    assert "Traceback" not in result.stderr  # slow machines report progress there
    assert (tmp_path / "x.html").stat().st_size > 10_000


def test_help_does_not_depend_on_docstrings(tmp_path: Path) -> None:
    texts = [
        run(*options, "-m", "agents", "grade", "-h", folder=tmp_path).stdout
        for options in ([], ["-OO"])
    ]
    assert texts[0] == texts[1]
    assert "Example: warehouse" in texts[0]


def test_a_record_is_saved_as_a_page_without_matplotlib(tmp_path: Path) -> None:
    class Waiting:
        def reset(self) -> None: ...

        def act(self, observation: object) -> str:
            return "WAIT"

    record_episode(WarehouseEnv(max_steps=3), Waiting(), seed=1).save(tmp_path / "x.npz")
    program = "import sys; sys.modules['matplotlib'] = None; import warehouse_core as core;"
    program += "replay = core.replay_animation(core.Episode.load('x.npz'));"
    program += "replay.save('x.html'); replay.save('x.gif')"
    result = run("-c", program, folder=tmp_path)
    assert "x.gif: without matplotlib only .html is possible" in result.stderr
    assert (tmp_path / "x.html").stat().st_size > 10_000
