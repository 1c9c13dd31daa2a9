"""The batteries of a fleet, in steps or in joules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import MAX_STEPS, one_of, real_number, settle, whole_number
from warehouse_core.motion.grid import nominal_joules
from warehouse_core.task.rules import CHARGE

STEPS, JOULES = "steps", "joules"
UNITS = (STEPS, JOULES)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Battery:
    """The battery of each robot of a fleet.

    Ageing and temperature are left out: a full charge is the same for ever.

    Args:
        capacity: units of a full charge, at least 1.
        unit: ``"steps"``: every step costs one; ``"joules"``: it costs what its motion cost.
        charge: units that a step of waiting on a charger adds; ``None`` is ``CHARGE`` steps, or in
            joules the nominal cost of as many moves. That is at a constant current.
        knee: share of a full charge from which on the voltage is constant instead, so that the
            current falls in proportion to what is missing; above 0. 1 is a constant current up to
            the full charge; lithium cells have about 0.8.

    Raises:
        ValueError: a value that is not allowed.
        TypeError: ``capacity`` or ``charge`` is not an integer.

    Example:
        >>> from warehouse_core import Battery, FleetEnv
        >>> env = FleetEnv(robots=2, battery=Battery(20_000, "joules"))
        >>> observations, info = env.reset()
        >>> env.state_of_charge
        [1.0, 1.0]
    """

    capacity: int = 200
    unit: str = STEPS
    charge: int | None = None
    knee: float = 1.0

    def __post_init__(self) -> None:
        settle(self, capacity=whole_number("battery", self.capacity, 1, MAX_STEPS))
        one_of("unit", self.unit, UNITS)
        if self.charge is not None:
            settle(self, charge=whole_number("charge", self.charge, 1, MAX_STEPS))
        settle(self, knee=real_number("knee", self.knee, 0.0, 1.0, above=True))

    def step_cost(self, cell_size: float) -> float:
        """Return what a move costs nominally."""
        return 1.0 if self.unit == STEPS else nominal_joules(cell_size, moving=True)

    def step_charge(self, cell_size: float) -> float:
        """Return what a step of waiting on a charger adds."""
        return CHARGE * self.step_cost(cell_size) if self.charge is None else self.charge

    @property
    def tail(self) -> float:
        """The last units of a full charge, which are charged at a constant voltage."""
        return (1 - self.knee) * self.capacity

    def supplied(self, missing: Floats, charge: float) -> Floats:
        """Return the units that a step of charging adds.

        Args:
            missing: ``[N]`` units that are missing from a full charge.
            charge: units that a step adds at a constant current.
        """
        steady: Floats = np.minimum(missing - np.minimum(missing, self.tail), charge)
        if not self.tail:
            return steady
        rest = 1 - steady / charge  # of the step, at a constant voltage
        falling: Floats = np.minimum(missing, self.tail) * -np.expm1(-rest * charge / self.tail)
        return steady + falling
