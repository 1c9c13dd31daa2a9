"""A newcomer follows the README and the mini-lab in a fresh copy, without a display."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import ROOT
from helpers.handbook import CELL, INSTALL, blocks_of

pytestmark = pytest.mark.slow

RUN_NOTEBOOK = """
import nbformat
from nbclient import NotebookClient

NotebookClient(nbformat.read("agents/handbook/mini_lab.ipynb", 4), timeout=600).execute()
"""


class Newcomer:
    """A shell in a copy of the repository, whose environment is active."""

    def __init__(self, folder: Path) -> None:
        self.folder, bin_folder = folder, folder / ".venv" / "bin"
        path = os.pathsep.join([str(bin_folder), os.path.dirname(sys.executable), os.defpath])
        self._variables = {"HOME": str(folder.parent), "PATH": path, "LANG": "C.UTF-8"}
        files = subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True)
        for name in files.splitlines():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)

    def run(self, *words: str) -> str:
        """Run a command and return its output; it must succeed without a traceback."""
        done = subprocess.run(
            words, cwd=self.folder, env=self._variables, capture_output=True, text=True, check=False
        )
        text = f"{' '.join(words)}\n{done.stdout}{done.stderr}"
        assert (done.returncode, "Traceback" in text) == (0, False), text
        return text


def test_a_newcomer_follows_the_readme_and_the_mini_lab(tmp_path: Path) -> None:
    newcomer = Newcomer(tmp_path / "lab")
    newcomer.run("python3", "-m", "venv", ".venv")
    newcomer.run("pip", "install", "-q", "-e", ".", "ipykernel", "nbclient", "nbformat")
    assert "pip install" in newcomer.run("sh", "-c", "! warehouse run --backend physics")
    newcomer.run("python", "-c", RUN_NOTEBOOK)
    blocks = [*blocks_of(ROOT / "README.md")]
    lines = [line for each in blocks if each.language == "sh" for line in each.text.splitlines()]
    for line in lines:
        if not line.startswith(INSTALL) or "warehouse" in line:  # the other one runs all tests
            newcomer.run("sh", "-c", line)
    newcomer.run("python", "-c", "\n".join(each.text for each in blocks if each.language == CELL))
    saved = {word for line in lines for word in line.split() if word.endswith(".html")}
    assert len(saved) >= 3
    assert [name for name in saved if not (newcomer.folder / name).is_file()] == []
