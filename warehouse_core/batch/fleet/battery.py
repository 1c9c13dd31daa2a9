"""The batteries of a fleet, in steps or in joules."""

from __future__ import annotations

from dataclasses import dataclass

from warehouse_core.arguments import MAX_STEPS, one_of, settle, whole_number
from warehouse_core.motion.grid import nominal_joules
from warehouse_core.task.rules import CHARGE

STEPS, JOULES = "steps", "joules"
UNITS = (STEPS, JOULES)


@dataclass(frozen=True)
class Battery:
    """The battery of each robot of a fleet.

    Args:
        capacity: units of a full charge, at least 1.
        unit: ``"steps"``: every step costs one; ``"joules"``: it costs what its motion cost.
        charge: units that a step of waiting on a charger adds; ``None`` is ``CHARGE`` steps, or in
            joules the nominal cost of as many moves.

    Raises:
        ValueError: a value that is not allowed.
        TypeError: ``capacity`` or ``charge`` is not an integer.
    """

    capacity: int = 200
    unit: str = STEPS
    charge: int | None = None

    def __post_init__(self) -> None:
        settle(self, capacity=whole_number("battery", self.capacity, 1, MAX_STEPS))
        one_of("unit", self.unit, UNITS)
        if self.charge is not None:
            settle(self, charge=whole_number("charge", self.charge, 1, MAX_STEPS))

    def step_cost(self, cell_size: float) -> float:
        """Return what a move costs nominally."""
        return 1.0 if self.unit == STEPS else nominal_joules(cell_size, moving=True)

    def step_charge(self, cell_size: float) -> float:
        """Return what a step of waiting on a charger adds."""
        return CHARGE * self.step_cost(cell_size) if self.charge is None else self.charge
