"""Only regular files are opened, and reading stops at a limit."""

import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from agents.lab.experiments.plan import read_plan_file
from agents.learning.policy_network import PolicyNetwork
from agents.learning.q_table import load_table
from warehouse_core import Episode, Layout
from warehouse_core.files.reading import open_file, read_file
from warehouse_core.orders.files import load_orders
from warehouse_core.world.map_files import load_map
from warehouse_core.world.named_layouts import find_layout
from warehouse_core.world.scenarios import load_scenarios

READERS: dict[str, Callable[[Path], Any]] = {
    "bytes": open_file,
    "episode": Episode.load,
    "network": PolicyNetwork.load,
    "Q-table": load_table,
    "layout": Layout.load,
    "layout by name": find_layout,
    "map": load_map,
    "scenarios": load_scenarios,
    "orders": load_orders,
    "plan": read_plan_file,
}


@pytest.fixture
def others(tmp_path: Path) -> dict[str, Path]:
    """Return paths of a folder, a pipe, a link to one, a socket and a device."""
    paths = {name: tmp_path / f"{name}.x" for name in ("folder", "pipe", "link", "socket")}
    paths["folder"].mkdir()
    os.mkfifo(paths["pipe"])
    paths["link"].symlink_to(paths["pipe"])
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(paths["socket"]))
    return paths | {"device": Path("/dev/./zero")}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_what_is_no_file_is_not_opened_and_not_waited_for(others, read) -> None:
    for name, path in others.items():
        kind = "pipe" if name == "link" else name
        with pytest.raises(OSError, match=f"it is a {kind}, not a file") as caught:
            read(path)
        assert caught.value.filename == str(path)


def test_no_more_than_a_limit_is_read(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_file(path, 5) == b"12345"
    with pytest.raises(OSError, match="it is longer than 4 bytes") as caught:
        read_file(path, 4)
    assert caught.value.filename == str(path)
