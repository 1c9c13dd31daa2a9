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


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a ZIP file with the packages."""
    archive = tmp_path_factory.mktemp("archive") / "lab.zip"
    with zipfile.ZipFile(archive, "w") as packed:
        for package in ("warehouse_core", "warehouse_physics", "agents"):
            for file in (ROOT / package).rglob("*"):
                if file.is_file() and "__pycache__" not in file.parts:
                    packed.write(file, file.relative_to(ROOT))
    return archive


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("sweep --preset escape -n 1 -j 1", "5 combinations, 1 episode each, 0 done"),
        ("grade greedy", "of 100 points"),
    ],
)
def test_commands_run_from_a_zip_file(archive: Path, tmp_path: Path, words: str, said: str) -> None:
    program = f"import sys; sys.path.insert(0, {str(archive)!r}); from agents.__main__ import main;"
    program += "assert '.zip' in main.__code__.co_filename;"
    program += f"sys.argv[1:] = {words.split()!r}; main()"
    result = run("-c", program, folder=tmp_path)
    assert (result.returncode, said in result.stdout) == (0, True), result.stderr
    assert "Traceback" not in result.stderr  # slow machines report progress there


def test_pages_are_made_from_a_zip_file(archive: Path, tmp_path: Path) -> None:
    program = f"import sys; sys.path.insert(0, {str(archive)!r}); import warehouse_core as core;"
    program += "assert '.zip' in core.__file__; from agents import GreedyAgent;"
    program += "record = core.record_episode(core.WarehouseEnv(), GreedyAgent(seed=1), seed=1);"
    program += "core.replay_animation(record).save('x.html')"
    result = run("-c", program, folder=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
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
