"""Calls of an object that must not overlap."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def exclusive(
    method: Callable[Concatenate[Any, Arguments], Returned],
) -> Callable[Concatenate[Any, Arguments], Returned]:
    """Make a method raise ``RuntimeError`` while an exclusive method of the same object runs.

    That may be in another thread: two steps of one pymunk space at a time end the interpreter. The
    object has an attribute ``is_busy``, which is false at first.
    """

    @wraps(method)
    def alone(self: Any, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        # No other thread and no interrupt comes between this test and the ``try``: Python switches
        # threads and handles signals at calls and backward jumps only.
        if self.is_busy:
            raise RuntimeError(
                f"{method.__name__}() while another call of the same motion is running; "
                "each thread needs an environment of its own"
            )
        self.is_busy = True
        try:
            return method(self, *args, **kwargs)
        finally:
            self.is_busy = False

    return alone
