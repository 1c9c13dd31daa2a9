"""The folder that ``warehouse playground`` writes, without Pyodide."""

import hashlib
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest
from helpers.command_line import Refused
from helpers.servers import served

from agents.lab.grading.rubric import own_rubrics
from agents.lab.playground import runtime
from agents.lab.playground.page import SCRIPTS

CONTENTS = {"python.wasm": b"python", "numpy.whl": b"numpy"}


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with small files in place of Pyodide's."""
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in CONTENTS.items()}
    monkeypatch.setattr(runtime, "FILES", digests)
    folder = tmp_path / "files"
    folder.mkdir()
    for name, content in CONTENTS.items():
        (folder / name).write_bytes(content)
    return folder


@pytest.fixture
def server(files: Path) -> Iterator[str]:
    """Yield the address of a server of these files."""
    with served(files) as address:
        yield address


def test_the_folder_has_all_that_the_page_loads(files, tmp_path, warehouse) -> None:
    page = tmp_path / "a page"
    result = warehouse("playground", "-o", page, "--pyodide", files)
    assert result.out.splitlines()[-1].endswith(f"python -m http.server -d '{page}'")
    text = (page / "index.html").read_text(encoding="utf-8")
    loaded = {*re.findall(r'(?:src|href)="([\w.]+)"', text), *SCRIPTS}
    for name in SCRIPTS:
        script = (page / name).read_text(encoding="utf-8")
        loaded.update(re.findall(r'from "\./(\w+\.js)"', script))
    settings = json.loads(
        re.findall(r'<script type="application/json"[^>]*>(.*)</script>', text)[0]
    )
    assert {path.name for path in page.iterdir()} == {
        *loaded, settings["wheel"], "index.html", "pyodide"
    }  # fmt: skip
    assert {path.name: path.read_bytes() for path in (page / "pyodide").iterdir()} == CONTENTS
    assert "trap" in settings["layouts"]
    assert "class MyAgent" in settings["exercises"]["mini_lab"]["starter"]
    assert settings["exercises"].keys() == own_rubrics().keys()
    assert settings["exercises"]["exercise-08"]["rows"] == settings["layouts"]["maze"]
    assert "rows" not in settings["exercises"]["exercise-02"]


def test_files_come_from_a_server_and_only_if_they_are_missing(files, server, tmp_path) -> None:
    page = tmp_path / "page"
    page.mkdir()
    runtime.copy_runtime(server, page)
    (files / "numpy.whl").unlink()
    runtime.copy_runtime(server, page)
    assert {path.name: path.read_bytes() for path in page.iterdir()} == CONTENTS


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda path: path.write_bytes(b"other"), r"numpy.whl in .* does not belong to Pyodide \d"),
        (lambda path: path.unlink(), "numpy.whl cannot be read from .*No such file"),
    ],
)
def test_other_files_are_refused_and_no_page_is_written(
    damage: object, message: str, files: Path, tmp_path: Path, refused: Refused
) -> None:
    assert callable(damage)
    damage(files / "numpy.whl")
    assert re.search(message, refused("playground", "-o", tmp_path / "page", "--pyodide", files))
    assert not (tmp_path / "page" / "index.html").exists()


def test_nothing_is_written_if_there_are_no_files(tmp_path: Path, refused: Refused) -> None:
    nowhere = tmp_path / "nowhere"
    message = refused("playground", "-o", tmp_path / "page", "--pyodide", nowhere)
    assert "pyodide.mjs cannot be read from" in message
    assert not (tmp_path / "page").exists()


def test_a_server_without_the_files_is_named(server: str, files: Path, tmp_path: Path) -> None:
    (files / "python.wasm").unlink()
    with pytest.raises(runtime.PyodideError, match=r"python.wasm cannot be read from .*404"):
        runtime.copy_runtime(server, tmp_path)


def test_the_wheel_can_be_installed_and_is_the_same_each_time(tmp_path: Path) -> None:
    from agents.lab.playground.wheel import write_wheel

    folders = [tmp_path / "first", tmp_path / "second"]
    for folder in folders:
        folder.mkdir()
    names = [write_wheel(folder) for folder in folders]
    members = ZipFile(folders[0] / names[0]).namelist()
    assert "agents/handbook/exercises/exercise-02.py" in members
    assert not [name for name in members if "solutions" in name]
    first, second = (folder / name for folder, name in zip(folders, names, strict=True))
    assert first.read_bytes() == second.read_bytes()
    target = tmp_path / "installed"
    words = ["install", "--no-deps", "--no-index", "--quiet", "--target", str(target), str(first)]
    subprocess.run([sys.executable, "-m", "pip", *words], check=True)
    code = (
        "import agents, warehouse_core; from importlib.metadata import entry_points\n"
        "env = warehouse_core.WarehouseEnv(); print(agents.__file__, env.reset()['robot_pos'])"
    )
    printed = subprocess.check_output(
        [sys.executable, "-c", code], env={"PYTHONPATH": str(target)}, text=True
    )
    assert printed.split()[0].startswith(str(target))
