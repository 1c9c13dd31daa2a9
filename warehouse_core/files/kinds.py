"""What a path is that is not a file."""

from __future__ import annotations

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
