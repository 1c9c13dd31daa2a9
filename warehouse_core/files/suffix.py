"""The suffix of a file, which names its format."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from warehouse_core.errors import FormatError


def check_suffix(path: Path, allowed: Collection[str]) -> str:
    """Return the suffix of ``path`` in lower case.

    Raises:
        FormatError: it is not allowed; the message lists those that are.
    """
    suffix = path.suffix.lower()
    if suffix not in allowed:
        given = suffix or "a file without a suffix"
        raise FormatError(f"{path}: cannot save as {given}; allowed: {', '.join(allowed)}")
    return suffix
