"""Files that a stranger may have written: opened only if they are files, and read up to a limit."""

from __future__ import annotations

import errno
import os
from io import BufferedReader
from pathlib import Path


def not_a_file(path: Path) -> str | None:
    """Return what a path is if it exists and is not a file, in words; otherwise ``None``.

    Reading a pipe may wait for ever, and a device may have no end.
    """
    if not path.exists() or path.is_file():
        return None
    kinds = {"folder": path.is_dir, "pipe": path.is_fifo, "socket": path.is_socket}
    kind = next((kind for kind, is_one in kinds.items() if is_one()), "device")
    return f"it is a {kind}, not a file"


_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0)
"""Flag of a pipe that has taken the file's place meanwhile; Windows has none."""


def open_file(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a file for reading bytes.

    Raises:
        OSError: there is no such file, it cannot be opened, or it is a folder, a pipe, a socket or
            a device.
    """
    if (kind := not_a_file(Path(path))) is not None:
        raise OSError(errno.EISDIR if Path(path).is_dir() else errno.EINVAL, kind, str(path))
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | _WITHOUT_WAITING))


def read_file(path: str | os.PathLike[str], max_bytes: int) -> bytes:
    """Return the content of a file that is not longer than a limit.

    Raises:
        OSError: it is longer, or as for ``open_file``.
    """
    with open_file(path) as file:
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise OSError(errno.EFBIG, f"it is longer than {max_bytes:,} bytes", str(path))
    return data
