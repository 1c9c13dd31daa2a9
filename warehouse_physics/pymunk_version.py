"""Check the version of pymunk before anything of it is used."""

from __future__ import annotations

import pymunk

MIN_VERSION, BELOW_VERSION = (7, 1), (8, 0)


def check_version(version: str) -> None:
    """Raise if this backend does not support a version of pymunk.

    Raises:
        ImportError: naming the version, and those that are supported.
    """
    try:
        major, minor = map(int, version.split(".")[:2])
    except ValueError:
        major, minor = 0, 0
    if not MIN_VERSION <= (major, minor) < BELOW_VERSION:
        raise ImportError(f"pymunk {version} is installed; 7.1 or later, but below 8, is needed")


check_version(pymunk.version)
