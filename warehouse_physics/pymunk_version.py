"""Refuse a pymunk that this backend was not written for, before anything of it is used."""

from __future__ import annotations

import pymunk

LEAST, BELOW = (7, 1), (8, 0)


def check_version(version: str) -> None:
    """Check a version of pymunk.

    Raises:
        ImportError: it is none of those that this backend was written for.
    """
    try:
        major, minor = map(int, version.split(".")[:2])
    except ValueError:
        major, minor = 0, 0
    if not LEAST <= (major, minor) < BELOW:
        raise ImportError(f"pymunk {version} is installed; 7.1 or later, but below 8, is needed")


check_version(pymunk.version)
