"""Atomic writes: a file appears complete or not at all."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from warehouse_core.errors import FormatError

PART = ".part"
"""Suffix of the folder of a file that is being written."""


def check_target(target: Path) -> None:
    """Raise if no file can be written to a path.

    Raises:
        OSError: it is a folder, or its folder does not exist.
    """
    if target.is_dir():
        raise IsADirectoryError(f"{target} is a folder, not a file")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {target.parent} does not exist")


def check_suffix(path: Path, allowed: Collection[str]) -> str:
    """Return the suffix of ``path`` in lower case.

    Raises:
        FormatError: it is not in ``allowed``.
    """
    suffix = path.suffix.lower()
    if suffix not in allowed:
        given = suffix or "a file without a suffix"
        raise FormatError(f"{path}: cannot save as {given}; allowed: {', '.join(allowed)}")
    return suffix


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Yield a path to write to; move that file to ``path`` when the block succeeds.

    It is named like ``path``, because writers choose their format by the suffix. It is in a new
    folder beside ``path`` that only this user can enter, so that no other program writes or links
    there. On any error it is removed, and an existing file at ``path`` is left unchanged.

    Raises:
        OSError: the folder does not exist or cannot be written; an error of writing, also one in
            the block, names ``path``.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core.files import atomic_path
        >>> with atomic_path("notes.txt") as path:
        ...     count = path.write_text("whole, or not there")
        >>> Path("notes.txt").read_text()
        'whole, or not there'
    """
    target = Path(path)
    check_target(target)
    try:
        with TemporaryDirectory(prefix=".", suffix=PART, dir=target.parent) as folder:
            part = Path(folder, target.name)
            yield part
            part.replace(target)
    except OSError as error:
        # A full disk names no file, and the names in the new folder say nothing to a user.
        if error.strerror and (error.filename is None or PART in str(error.filename)):
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise
