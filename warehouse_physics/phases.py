"""The phases of a drive from cell to cell, as a table.

A robot at rest sets off and goes for a time that is known when it sets off. Then it brakes. When it
should stand, the table says what it does next, depending on where it stands and what it has met. A
robot with wheels turns first, if it would otherwise miss its target, and brakes after the turn too.

A hit with something that blocks a robot makes it brake in any phase. Robots that are held, and
robots at rest that others push, leave their phases in ``giving_way.py``.
"""

from __future__ import annotations

import sys

REST, GO, BRAKE, HELD, TURN = range(5)
"""Phases. A held robot waits until all others are at rest."""

DUE, ROLLS, LATE, THERE, MET, OFF = range(6)
"""Events that end a phase.

``DUE``: the time of the phase is over. The others are for a robot that should stand by now.
``ROLLS``: it still moves. ``LATE``: the time for its action is over. ``THERE``: it is at its
target. ``MET``: it is not there, and other robots may block it. ``OFF``: it is not there, and may
try again."""

NEXT = {
    (GO, DUE): BRAKE,
    (TURN, DUE): BRAKE,
    (BRAKE, ROLLS): BRAKE,
    (BRAKE, LATE): REST,
    (BRAKE, THERE): REST,
    (BRAKE, MET): HELD,
    (BRAKE, OFF): GO,
}
"""The phase that follows a phase after an event."""

NEVER = sys.maxsize
"""End of the phase of a robot that has nothing to do, as a substep that is never reached."""

AT_REST = 1e-6
"""Speed in m/s below which a robot is at rest. After a hit the solver may leave a higher speed, and
the robot then goes on braking."""
