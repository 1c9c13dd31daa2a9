"""Costs of a robot's actions in steps, or in seconds or joules measured with a backend.

A measurement is a short run on an open floor. It measures a move and standing still, each with and
without an item.
"""

from __future__ import annotations

from contextlib import closing
from typing import NamedTuple

from warehouse_core.arguments import one_of
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.world.layout import Layout

STEPS, SECONDS, JOULES = "steps", "seconds", "joules"
COSTS = (STEPS, SECONDS, JOULES)
"""Names of the measures of cost."""

FLOOR = Layout(["......."] * 3)
"""Layout for measurements, large enough for their moves."""

WARM_UP = 1
"""Number of moves before the measured move, which turn the robot in its direction."""


class ActionCosts(NamedTuple):
    """The cost of each action. A move by one cell has a cost without and with the item."""

    move_empty: float
    move_loaded: float
    pick: float
    drop: float


ONE_EACH = ActionCosts(1.0, 1.0, 1.0, 1.0)


def action_costs(measure: str = STEPS, backend: Backend = "physics") -> ActionCosts:
    """Return the costs of the actions in one of the measures ``COSTS``.

    Args:
        measure: measure of cost.
        backend: motion backend with which seconds and joules are measured.

    Raises:
        ValueError: ``measure`` is not one of ``COSTS``.
        BackendError: the backend does not exist.
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
    """Return the cost of one action, from rest to rest, between centres of cells."""
    with closing(make_motion(backend)) as motion:
        motion.reset(FLOOR, [(1, 1)], 0)
        for _ in range(WARM_UP + 1):
            outcome = motion.advance((displacement,), (loaded,))[0]
        return float(getattr(outcome, measure))
