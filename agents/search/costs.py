"""What a robot's actions cost: steps, or seconds or joules as a backend measures them.

The physics backend is asked, not looked up in a book: a short run on an open floor says what a move
and a stand cost, empty and loaded.
"""

from __future__ import annotations

from typing import NamedTuple

from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import Outcome
from warehouse_core.world.layout import Layout

STEPS, SECONDS, JOULES = "steps", "seconds", "joules"
COSTS = (STEPS, SECONDS, JOULES)
"""What can be counted."""

FLOOR = Layout(["......."] * 3)
"""Wide enough for the moves of a calibration."""

WARM_UP = 1
"""Moves before the one that counts, after which the robot heads where it goes."""


class ActionCosts(NamedTuple):
    """What each action costs.

    Attributes:
        move_empty: one cell with empty hands.
        move_loaded: one cell with the item.
        pick: taking the item.
        drop: delivering it.
    """

    move_empty: float
    move_loaded: float
    pick: float
    drop: float


ONE_EACH = ActionCosts(1.0, 1.0, 1.0, 1.0)


def action_costs(measure: str = STEPS, backend: Backend = "physics") -> ActionCosts:
    """Return what actions cost.

    Args:
        measure: one of ``COSTS``.
        backend: that is asked for seconds and joules.

    Raises:
        ValueError: another measure.
        BackendError: the backend is not there.
    """
    if measure == STEPS:
        return ONE_EACH
    if measure not in COSTS:
        raise ValueError(f"cost is {measure!r}; allowed: {', '.join(COSTS)}")
    moves = {loaded: _measured(backend, measure, (0, 1), loaded) for loaded in (False, True)}
    stands = {loaded: _measured(backend, measure, (0, 0), loaded) for loaded in (False, True)}
    return ActionCosts(moves[False], moves[True], stands[False], stands[True])


def _measured(backend: Backend, measure: str, displacement: tuple[int, int], loaded: bool) -> float:
    """Return what one action costs, from rest in the middle of a cell to rest in another."""
    motion = make_motion(backend)
    try:
        motion.reset(FLOOR, [(1, 1)], 0)
        outcome: Outcome | None = None
        for _ in range(WARM_UP + 1):
            outcome = motion.advance((displacement,), (loaded,))[0]
        return float(getattr(outcome, measure))
    finally:
        motion.close()
