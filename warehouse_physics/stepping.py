"""Substeps of a space up to the first hit; no error of a callback is lost.

Half of the time of ``Space.step`` passes in Python, for objects that were added or removed since
the last step. Where there are none, Chipmunk's own function is called instead: a private part of
pymunk, which its versions 7.1 to 7.3 have in the same form. With a later version ``Space.step`` is
called.

Chipmunk calls Python through cffi, which prints the errors of a callback and drops them. So they
are kept, and raised after the call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import pymunk

IS_KNOWN = pymunk.version.startswith(("7.1.", "7.2.", "7.3."))
"""True if this version of pymunk has the private parts that are used here."""


class Hits(list[Any]):
    """Hits that have begun, each as ``note`` describes it, and the errors of describing them."""

    def __init__(self, note: Callable[[pymunk.Arbiter], Iterable[Any]]) -> None:
        super().__init__()
        self._note = note

    def begin(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Keep a hit before the solver changes any velocity."""
        try:
            self.extend(self._note(arbiter))
        except BaseException as error:
            self.append(error)

    def take(self) -> list[Any]:
        """Return the hits, and forget them; raise the first error among them."""
        hits = self.copy()
        self.clear()
        for each in hits:
            if isinstance(each, BaseException):
                raise each
        return hits


class Stepper:
    """Steps a space, and notes hits of bodies whose collision types are one of ``pairs``.

    ``note`` is called as two begin to touch, and returns hits, one or more for the touch.
    """

    def __init__(
        self,
        space: pymunk.Space,
        time_step: float,
        note: Callable[[pymunk.Arbiter], Iterable[Any]],
        pairs: list[tuple[int, int]],
    ) -> None:
        self._space, self._time_step, self._hits = space, time_step, Hits(note)
        for pair in pairs:
            space.on_collision(*pair, begin=self._hits.begin)

    def run(self, now: int, until: int) -> tuple[int, list[Any]]:
        """Step from substep ``now`` to ``until`` or the first hits; return when, and the hits.

        Raises:
            BaseException: an error, or an interrupt, while a hit was noted.
        """
        space = self._space
        if not IS_KNOWN or _has_changes(space):
            return self._run(partial(space.step, self._time_step), now, until)
        # A callback that adds or removes something has to wait, as in a step of pymunk.
        space._locked = True
        try:
            return self._run(partial(lib.cpSpaceStep, space._space, self._time_step), now, until)
        finally:
            space._locked = False

    def _run(self, step: Callable[[], None], now: int, until: int) -> tuple[int, list[Any]]:
        hits = self._hits
        hits.clear()  # An interrupt may have ended the last run after a hit.
        for substep in range(now + 1, until + 1):
            step()
            if hits:
                return substep, hits.take()
        return until, []


def _has_changes(space: pymunk.Space) -> bool:
    """Return whether a step of pymunk would do more than call Chipmunk's own."""
    return bool(
        space._bodies_to_check
        or space._removed_shapes
        or space._add_later
        or space._remove_later
        or space._post_step_callbacks
    )


if IS_KNOWN:  # pragma: no branch - a later pymunk
    from pymunk._chipmunk_cffi import lib
