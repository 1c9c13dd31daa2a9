"""Former names of attributes and methods, which keep working for one version."""

from __future__ import annotations

import warnings
from typing import Any


class Renamed:
    """A former name of an attribute, property or method, which warns and returns the new one.

    Assign it to the former name in the class: ``ways = Renamed("routes")``.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __set_name__(self, owner: type, former: str) -> None:
        self._former = f"{owner.__name__}.{former}"

    def __get__(self, instance: object, owner: type) -> Any:
        if instance is None:
            return self  # so that tools that list the names of a class print no warning
        warn_renamed(self._former, self._name)
        return getattr(instance, self._name)


def warn_renamed(former: str, name: str) -> None:
    """Warn the caller's caller that ``former`` has been renamed to ``name``."""
    warnings.warn(
        f"{former} has been renamed to {name}; the former name will be removed",
        DeprecationWarning,
        stacklevel=3,
    )
