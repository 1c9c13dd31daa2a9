"""Costs of a robot's actions: steps, or seconds or joules as measured with a backend.

The measurement is a short run on an open floor, of a move and of standing still, empty and loaded.
"""

from __future__ import annotations

from contextlib import closing
from typing import NamedTuple

from warehouse_core.arguments import one_of
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.world.layout import Layout

STEPS, SECONDS, JOULES = "steps", "seconds", "joules"
COSTS = (STEPS, SECONDS, JOULES)
"""Measures of cost."""

FLOOR = Layout(["......."] * 3)
"""Layout of a measurement, large enough for its moves."""

WARM_UP = 1
"""Moves before the one that is measured; after them the robot faces its direction."""


class ActionCosts(NamedTuple):
    """The cost of each action; a move is one cell, without or with the item."""

    move_empty: float
    move_loaded: float
    pick: float
    drop: float


ONE_EACH = ActionCosts(1.0, 1.0, 1.0, 1.0)


def action_costs(measure: str = STEPS, backend: Backend = "physics") -> ActionCosts:
    """Return the costs of actions by one of ``COSTS``; seconds and joules depend on the backend.

    Raises:
        ValueError: ``measure`` is unknown.
        BackendError: there is no such backend.
    """
    if one_of("cost", measure, COSTS) == STEPS:
        return ONE_EACH
    move, stand = (0, 1), (0, 0)
    return ActionCosts(
        move_empty=_measured(backend, measure, move, False),
        move_loaded=_measured(backend, measure, move, True),
        pick=_measured(backend, measure, stand, False),
        drop=_measured(backend, measure, stand, True),
    )


def _measured(backend: Backend, measure: str, displacement: tuple[int, int], loaded: bool) -> float:
    """Return the cost of one action, from rest to rest in the middle of a cell."""
    with closing(make_motion(backend)) as motion:
        motion.reset(FLOOR, [(1, 1)], 0)
        for _ in range(WARM_UP + 1):
            outcome = motion.advance((displacement,), (loaded,))[0]
        return float(getattr(outcome, measure))
