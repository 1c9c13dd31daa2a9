"""What keeps a real robot from doing what it was told: off by default, and seeded."""

from __future__ import annotations

import operator
import random
from collections.abc import Iterable
from dataclasses import dataclass, fields

from warehouse_core import Cell
from warehouse_physics.robot_spec import GRAVITY


@dataclass(frozen=True, slots=True)
class Disturbances:
    """How far the world departs from what the drive takes it for. The default is not at all.

    The drive plans as if all were nominal and corrects itself from where it really is, until its
    patience ends; the robot then stays where it has come to, which may be short of its goal.

    Attributes:
        actuation_noise: standard deviation of the commanded speed, as a share of it.
        slippery: cells whose floor transmits no more force than ``grip`` allows.
        grip: friction coefficient of wheels on slippery floor; wet ice has about 0.05.
        motor_strength: share of its force that the motor really has, 0 to 1.
        drag_spread: the drag of each cell is drawn within this share of the nominal, below 1.
        patience: times a free move takes after which no new attempt is made, at least 1.

    Raises:
        ValueError: naming the field, its value and what is allowed.
    """

    actuation_noise: float = 0.0
    slippery: frozenset[Cell] = frozenset()
    grip: float = 0.03
    motor_strength: float = 1.0
    drag_spread: float = 0.0
    patience: float = 2.0

    def __post_init__(self) -> None:
        allowed = {
            "actuation_noise": (0.0, 0.5),
            "grip": (0.0, 1.0),
            "motor_strength": (0.0, 1.0),
            "drag_spread": (0.0, 0.99),
            "patience": (1.0, 100.0),
        }
        for name, (least, most) in allowed.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise ValueError(f"{name} is {value!r}; it must be a number")
            if not least <= value <= most:
                raise ValueError(f"{name} is {value!r}; it must be {least}..{most}")
        object.__setattr__(self, "slippery", _checked_cells(self.slippery))

    @property
    def any(self) -> bool:
        """Whether anything departs from the nominal at all."""
        free = {"grip", "patience"}
        return any(
            getattr(self, each.name) != each.default
            for each in fields(self)
            if each.name not in free
        )


def _checked_cells(cells: Iterable[Cell]) -> frozenset[Cell]:
    try:
        return frozenset((operator.index(row), operator.index(col)) for row, col in cells)
    except (TypeError, ValueError):
        raise ValueError(f"slippery is {cells!r}; it must be cells (row, column)") from None


class Floor:
    """The floor of one episode and the chance in it.

    Args:
        disturbances: of this world.
        seed: of what is drawn.
    """

    def __init__(self, disturbances: Disturbances, seed: int) -> None:
        self._disturbances = disturbances
        self._seed = seed
        self._noise = random.Random(seed)
        self.patience = disturbances.patience

    def drag_factor(self, cell: Cell) -> float:
        """Return the drag of a cell as a share of the nominal, the same whenever it is asked."""
        spread = self._disturbances.drag_spread
        return random.Random(f"{self._seed} {cell}").uniform(1 - spread, 1 + spread)

    def force_limit(self, cell: Cell, motor_force: float, mass: float) -> float:
        """Return the most force in N that a motor gets onto the floor of ``cell``."""
        force = self._disturbances.motor_strength * motor_force
        if cell in self._disturbances.slippery:
            force = min(force, self._disturbances.grip * mass * GRAVITY)
        return force

    def speed_factor(self) -> float:
        """Draw the speed that a command leads to, as a share of what was commanded."""
        noise = self._noise.gauss(0.0, self._disturbances.actuation_noise)
        # No drive runs backwards by mistake, and twice the top speed is still safe to simulate.
        return 1.0 + min(max(noise, -1.0), 1.0)
