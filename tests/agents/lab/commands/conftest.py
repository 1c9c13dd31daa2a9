"""Tests of commands draw small pictures, in a folder of their own and without a display."""

from pathlib import Path

import pytest
from helpers.command_line import without_display


@pytest.fixture(autouse=True)
def in_a_folder_without_a_display(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small_pictures: None
) -> None:
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
