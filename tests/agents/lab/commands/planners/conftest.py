"""The tests of commands run in a folder of their own, without a display."""

from pathlib import Path

import pytest
from helpers.command_line import without_display


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small_pictures: None) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    without_display(monkeypatch)
