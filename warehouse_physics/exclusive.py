"""Calls of an object that must not overlap."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, Protocol, TypeVar


class Busy(Protocol):
    """An object with exclusive methods; ``is_busy`` is set while one of them runs."""

    is_busy: bool


Owner = TypeVar("Owner", bound=Busy)
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def exclusive(
    method: Callable[Concatenate[Owner, Arguments], Result],
) -> Callable[Concatenate[Owner, Arguments], Result]:
    """Make a method raise ``RuntimeError`` while an exclusive method of the same object runs.

    That may be in another thread: two steps of one pymunk space at a time end the interpreter.
    """

    @wraps(method)
    def alone(self: Owner, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
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
