"""Atomic writes: a file appears complete or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def check_target(target: Path) -> None:
    """Raise if no file can be written to a path.

    Raises:
        OSError: it is a folder, or its folder does not exist.
    """
    if target.is_dir():
        raise IsADirectoryError(f"{target} is a folder, not a file")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {target.parent} does not exist")


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to; rename it to ``path`` when the block succeeds.

    The suffix is kept, because writers choose their format by it. On any error the temporary file
    is removed and an existing file at ``path`` is left unchanged.

    Raises:
        OSError: the folder does not exist or cannot be written.
    """
    target = Path(path)
    check_target(target)
    part = target.with_name(f".{target.stem}.part{target.suffix}")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
