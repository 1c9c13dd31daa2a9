"""Reading of untrusted files: only regular files are opened, and only up to a limit is read."""

from __future__ import annotations

import errno
import os
from io import BufferedReader
from pathlib import Path


def not_a_file(path: Path) -> str | None:
    """Return a message if a path exists and is not a regular file; otherwise ``None``.

    Reading from a pipe may block forever, and a device may have no end.
    """
    if not path.exists() or path.is_file():
        return None
    kinds = {"folder": path.is_dir, "pipe": path.is_fifo, "socket": path.is_socket}
    kind = next((kind for kind, is_one in kinds.items() if is_one()), "device")
    return f"it is a {kind}, not a file"


_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0)
"""Flag that keeps ``open`` from blocking if a pipe has replaced the file; 0 on Windows."""


def open_file(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file for reading bytes.

    Raises:
        OSError: the file does not exist, cannot be opened, or is a folder, a pipe, a socket or a
            device.
    """
    if (kind := not_a_file(Path(path))) is not None:
        raise OSError(errno.EISDIR if Path(path).is_dir() else errno.EINVAL, kind, str(path))
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | _WITHOUT_WAITING))


def read_file(path: str | os.PathLike[str], max_bytes: int) -> bytes:
    """Return the content of a file of at most ``max_bytes`` bytes.

    Raises:
        OSError: the file is longer, or ``open_file`` fails.
    """
    with open_file(path) as file:
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise OSError(errno.EFBIG, f"it is longer than {max_bytes:,} bytes", str(path))
    return data
