"""The tests of commands run in a folder of their own, without a display."""

from pathlib import Path

import pytest
from helpers.command_line import without_display

from warehouse_core import shelf_layout
from warehouse_core.world import save_layout


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    without_display(monkeypatch)
    layout = shelf_layout(1, 2, aisle=2, pickups=2, dropoffs=2, chargers=1, seed=1)
    save_layout(layout, "shelves.txt")
