"""Methods of an object that must not run at the same time."""

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

    The other call may be in another thread: two simultaneous steps of one pymunk space crash the
    interpreter. The object needs an attribute ``is_busy``, which is false at first.
    """

    @wraps(method)
    def alone(self: Any, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        # Python switches threads and handles signals only at calls and at backward jumps. So
        # nothing can happen between this test and the ``try``.
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
