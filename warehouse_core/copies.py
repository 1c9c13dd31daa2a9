"""Copies of environments."""

from __future__ import annotations

from copy import deepcopy
from typing import Self


class CopiedWhole:
    """A base class of environments for which ``copy.copy`` makes a deep copy.

    With a shallow copy, two environments would share a motion and move each other's robots.
    """

    def __copy__(self) -> Self:
        return deepcopy(self)
