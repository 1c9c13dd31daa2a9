"""Disturbances of the nominal physics: off by default, and seeded."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, fields

from warehouse_core import Cell
from warehouse_core.arguments import (
    MAX_STEPS,
    as_cell,
    real_number,
    sequence_of,
    settle,
    whole_number,
)
from warehouse_core.motion.base import Conditions
from warehouse_core.motion.grid import GRAVITY
from warehouse_core.wording import brief


@dataclass(frozen=True, slots=True)
class Stop:
    """A failure of a robot, which brakes and stands still for some time.

    Attributes:
        robot: number of the robot.
        at: seconds from the reset to the failure.
        seconds: duration of the failure; ``math.inf`` if the robot has died.

    Raises:
        ValueError: naming the field, its value and what is allowed.
        TypeError: ``robot`` is not an integer.

    Example:
        >>> from warehouse_physics import Disturbances, DrivingMotion, Stop
        >>> stop = Stop(robot=0, at=20.0, seconds=60.0)
        >>> motion = DrivingMotion(disturbances=Disturbances(stops=(stop,)))
    """

    robot: int
    at: float
    seconds: float

    def __post_init__(self) -> None:
        robot = whole_number("robot", self.robot, 0, MAX_STEPS)
        seconds = real_number("seconds", self.seconds, above=True, finite=False)
        settle(self, robot=robot, at=real_number("at", self.at), seconds=seconds)


@dataclass(frozen=True, slots=True)
class Disturbances:
    """How far the physics departs from the nominal; by default not at all.

    The drive plans for the nominal physics and corrects itself from its actual position, until its
    patience ends. The robot then stays where it is, which may be short of its goal.

    Attributes:
        actuation_noise: standard deviation of the speed, as a share of the commanded one.
        slippery: cells whose floor limits the force of the motor by ``grip``.
        grip: friction coefficient of wheels on slippery floor; about 0.05 on wet ice.
        motor_strength: actual share of the motor force, 0 to 1.
        drag_spread: the drag of each cell is drawn within this share of the nominal, below 1.
        patience: durations of a free move after which no new attempt is made, at least 1; robots
            that drive through have no such limit.
        stops: failures of robots; only robots that drive through may have any.
        odometry: standard deviation of the way that a robot measures, as a share of it; see
            ``Odometry``. No body feels it.

    Raises:
        ValueError: naming the field, its value and what is allowed.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_physics import Disturbances, RigidBodyMotion
        >>> icy = Disturbances(slippery=frozenset({(1, 2)}), motor_strength=0.8)
        >>> env = WarehouseEnv(backend=RigidBodyMotion(disturbances=icy))
    """

    actuation_noise: float = 0.0
    slippery: frozenset[Cell] = frozenset()
    grip: float = 0.03
    motor_strength: float = 1.0
    drag_spread: float = 0.0
    patience: float = 2.0
    stops: tuple[Stop, ...] = ()
    odometry: float = 0.0

    def __post_init__(self) -> None:
        allowed = {
            "actuation_noise": (0.0, 0.5),
            "grip": (0.0, 1.0),
            "motor_strength": (0.0, 1.0),
            "drag_spread": (0.0, 0.99),
            "patience": (1.0, 100.0),
            "odometry": (0.0, 0.5),
        }
        for name, (minimum, maximum) in allowed.items():
            settle(self, **{name: real_number(name, getattr(self, name), minimum, maximum)})
        try:
            slippery = frozenset(as_cell("slippery", cell) for cell in self.slippery)
        except Exception:  # a user's ``__iter__`` may raise anything
            message = f"slippery is {brief(self.slippery)}; it must be cells (row, column)"
            raise ValueError(message) from None
        try:
            settle(self, slippery=slippery, stops=sequence_of("stops", self.stops, Stop))
        except TypeError as error:
            raise ValueError(str(error)) from None

    @property
    def conditions(self) -> Conditions:
        """Floor and motors, for records."""
        return Conditions(tuple(sorted(self.slippery)), self.motor_strength)

    @property
    def any(self) -> bool:
        """Whether anything departs from the nominal."""
        return self.is_felt or self.odometry > 0

    @property
    def is_felt(self) -> bool:
        """Whether bodies move otherwise than nominally."""
        return any(
            getattr(self, each.name) != each.default
            for each in fields(self)
            if each.name not in ("grip", "patience", "odometry")
        )


class FloorConditions:
    """Drag, grip and random numbers of one episode with these disturbances and this seed."""

    def __init__(self, disturbances: Disturbances, seed: int) -> None:
        self._disturbances, self.patience = disturbances, disturbances.patience
        self._seed, self._noise = seed, random.Random(seed)
        self.varies = bool(disturbances.drag_spread or disturbances.slippery)

    def drag_factor(self, cell: Cell) -> float:
        """Return the drag of a cell as a share of the nominal; it depends on seed and cell only."""
        spread = self._disturbances.drag_spread
        return random.Random(f"{self._seed} {cell}").uniform(1 - spread, 1 + spread)

    def force_limit(self, cell: Cell, motor_force: float, mass: float) -> float:
        """Return the largest force in N that the motor can exert on the floor of ``cell``."""
        force = self._disturbances.motor_strength * motor_force
        return min(force, self.grip_force(cell, mass))

    def grip_force(self, cell: Cell, mass: float) -> float:
        """Return the largest force in N that wheels find on a floor; no limit on the usual one."""
        is_slippery = cell in self._disturbances.slippery
        return self._disturbances.grip * mass * GRAVITY if is_slippery else math.inf

    def speed_factor(self) -> float:
        """Draw the actual speed of a profile as a share of the commanded one."""
        noise = self._noise.gauss(0.0, self._disturbances.actuation_noise)
        # No drive runs backwards, and twice the top speed is still safe to simulate.
        return 1.0 + min(max(noise, -1.0), 1.0)
