"""Atomic writes: a file either appears complete or does not appear."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from warehouse_core.errors import FormatError

PART = ".part"
"""Suffix of the temporary folder in which a file is written."""


def check_target(target: Path) -> None:
    """Raise an error if no file can be written to a path.

    Raises:
        OSError: the path is a folder, or its parent folder does not exist.
    """
    if target.is_dir():
        raise IsADirectoryError(f"{target} is a folder, not a file")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {target.parent} does not exist")


def check_suffix(path: Path, allowed: Collection[str]) -> str:
    """Return the suffix of ``path`` in lower case.

    Raises:
        FormatError: the suffix is not in ``allowed``.
    """
    suffix = path.suffix.lower()
    if suffix not in allowed:
        given = suffix or "a file without a suffix"
        raise FormatError(f"{path}: cannot save as {given}; allowed: {', '.join(allowed)}")
    return suffix


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to, and move the file to ``path`` when the block succeeds.

    The temporary file has the name of ``path``, because writers choose their format by the suffix.
    It lies in a new folder next to ``path`` that only this user can enter, so that no other program
    can write or link there. If the block fails, the temporary file is removed and an existing file
    at ``path`` stays unchanged.

    Raises:
        OSError: the folder does not exist or cannot be written to. Errors of writing inside the
            block name ``path`` too.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core.files import atomic_path
        >>> with atomic_path("notes.txt") as path:
        ...     count = path.write_text("complete, or not there")
        >>> Path("notes.txt").read_text()
        'complete, or not there'
    """
    target = Path(path)
    check_target(target)
    try:
        with TemporaryDirectory(prefix=".", suffix=PART, dir=target.parent) as folder:
            part = Path(folder, target.name)
            yield part
            part.replace(target)
    except OSError as error:
        # The error of a full disk names no file, and names in the new folder would confuse users.
        if error.strerror and (error.filename is None or PART in str(error.filename)):
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise
