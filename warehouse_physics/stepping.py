"""Substeps of a space up to the first hit, without losing errors of callbacks.

Half of the time of ``Space.step`` is spent in Python, on objects that were added or removed since
the last step. If there are none, this module calls Chipmunk's own function instead. That function
is a private part of pymunk, which is the same in versions 7.1 to 7.3. With later versions
``Space.step`` is called.

Chipmunk calls Python through cffi, which prints the errors of a callback and drops them. So this
module stores them, and raises them after the call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import pymunk

IS_KNOWN = pymunk.version.startswith(("7.1.", "7.2.", "7.3."))
"""True if this version of pymunk has the private parts that are used here."""


class Hits(list[Any]):
    """Hits that have begun, as ``note`` describes them, and errors that it raised."""

    def __init__(self, note: Callable[[pymunk.Arbiter], Iterable[Any]]) -> None:
        super().__init__()
        self._note = note

    def begin(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Store a hit before the solver changes any velocity."""
        try:
            self.extend(self._note(arbiter))
        except BaseException as error:
            self.append(error)

    def take(self) -> list[Any]:
        """Return the hits and clear the list, or raise the first error among them."""
        hits = self.copy()
        self.clear()
        for each in hits:
            if isinstance(each, BaseException):
                raise each
        return hits


class Stepper:
    """Steps a space, and notes when bodies begin to touch whose collision types are in ``pairs``.

    ``note`` is called for each new contact and returns one or more hits.
    """

    def __init__(
        self,
        space: pymunk.Space,
        time_step: float,
        note: Callable[[pymunk.Arbiter], Iterable[Any]],
        pairs: Iterable[tuple[int, int | None]],
    ) -> None:
        self._space, self._hits = space, Hits(note)
        self._time_step = time_step
        if IS_KNOWN:
            self._step = partial(lib.cpSpaceStep, space._space, time_step)
        for pair in pairs:
            space.on_collision(*pair, begin=self._hits.begin)

    def run(
        self, now: int, until: int, every: int = 0, look: Callable[[int], object] | None = None
    ) -> tuple[int, list[Any]]:
        """Step from substep ``now`` until the first hits; return the last substep and the hits.

        It steps to substep ``until`` if there are no hits. If ``every`` is not 0, it calls ``look``
        after every such number of substeps before the last one.

        Raises:
            BaseException: an error or an interrupt occurred while a hit was noted.
        """
        space = self._space
        if not IS_KNOWN or _has_changes(space):
            return self._run(partial(space.step, self._time_step), now, until, every, look)
        # As in a step of pymunk, objects that a callback adds or removes have to wait.
        space._locked = True
        try:
            return self._run(self._step, now, until, every, look)
        finally:
            space._locked = False

    def _run(
        self, step: Callable[[], None], now: int, until: int, every: int, look: Any
    ) -> tuple[int, list[Any]]:
        hits = self._hits
        hits.clear()  # An interrupt may have ended the last run after a hit.
        while now < until:
            due = min(now + every, until) if every else until
            for substep in range(now + 1, due + 1):
                step()
                if hits:
                    return substep, hits.take()
            now = due
            if now < until:
                look(now)
        return until, []


def read(body: pymunk.Body) -> tuple[float, float, float, float, float]:
    """Return the position ``x`` and ``y``, the velocity ``x`` and ``y``, and the angle of a body.

    Properties of pymunk take three times as long, because they create vectors.
    """
    if not IS_KNOWN:
        return *body.position, *body.velocity, body.angle
    handle = body._body
    position, velocity = lib.cpBodyGetPosition(handle), lib.cpBodyGetVelocity(handle)
    return position.x, position.y, velocity.x, velocity.y, lib.cpBodyGetAngle(handle)


def _has_changes(space: pymunk.Space) -> bool:
    """Return whether a step of pymunk would do more than to call Chipmunk's step."""
    return bool(
        space._bodies_to_check
        or space._removed_shapes
        or space._add_later
        or space._remove_later
        or space._post_step_callbacks
    )


if IS_KNOWN:  # pragma: no branch - a later pymunk
    from pymunk._chipmunk_cffi import lib
