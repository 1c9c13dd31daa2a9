"""A check of the version of pymunk, which runs before anything else is imported from it."""

from __future__ import annotations

import pymunk

MIN_VERSION, BELOW_VERSION = (7, 1), (8, 0)


def check_version(version: str) -> None:
    """Raise an error if this backend does not support a version of pymunk.

    Raises:
        ImportError: the version is not supported; the message has the version and what is needed.
    """
    try:
        major, minor = map(int, version.split(".")[:2])
    except ValueError:
        major, minor = 0, 0
    if not MIN_VERSION <= (major, minor) < BELOW_VERSION:
        raise ImportError(f"pymunk {version} is installed; 7.1 or later, but below 8, is needed")


check_version(pymunk.version)
