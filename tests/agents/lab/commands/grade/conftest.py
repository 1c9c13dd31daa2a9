"""The tests of the command run in a folder of their own."""

from pathlib import Path

import pytest
from helpers.command_line import without_display


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    without_display(monkeypatch)
