"""Copies of environments."""

from __future__ import annotations

from copy import deepcopy
from typing import Self


class CopiedWhole:
    """Base of environments, of which ``copy.copy`` makes a deep copy.

    Two environments that share a motion would move each other's robots.
    """

    def __copy__(self) -> Self:
        return deepcopy(self)
