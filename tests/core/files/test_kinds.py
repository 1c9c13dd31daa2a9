"""A path that is not a file is described."""

import os
import socket
from pathlib import Path

from warehouse_core.files.kinds import not_a_file


def test_the_kind_of_what_is_not_a_file_is_returned(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "to_pipe").symlink_to("pipe")
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(tmp_path / "socket"))
    kinds = {
        "file": None,
        "missing": None,
        "file/in_a_file": None,
        ".": "it is a folder, not a file",
        "pipe": "it is a pipe, not a file",
        "to_pipe": "it is a pipe, not a file",
        "socket": "it is a socket, not a file",
        os.devnull: "it is a device, not a file",
    }
    assert {name: not_a_file(tmp_path / name) for name in kinds} == kinds
