"""Disturbances of the nominal physics, which are off by default and depend on a seed."""

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
    """A failure of a robot, which brakes and then stays where it is for some time.

    Attributes:
        robot: number of the robot.
        at: seconds from the reset to the failure.
        seconds: duration of the failure; ``math.inf`` if the robot never drives again.

    Raises:
        ValueError: a field is out of range; the message has the field, its value and what is
            allowed.
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
    """Deviations from the nominal physics; by default there are none.

    A robot plans its drives for the nominal physics. At rest it compares its position with its
    target and drives again, until its patience ends. It then stays where it is, possibly short of
    its goal.

    Attributes:
        actuation_noise: standard deviation of the actual speed, as a share of the commanded speed.
        slippery: cells with slippery floor, on which ``grip`` limits the force of the motor.
        grip: friction coefficient between wheels and slippery floor; about 0.05 on wet ice.
        motor_strength: actual force of the motor as a share of the nominal force, 0 to 1.
        drag_spread: largest deviation of the drag of a cell, as a share of the nominal drag and
            below 1. Each cell has a random drag.
        patience: time after which a robot makes no new attempt, in durations of a free move, at
            least 1. It does not apply to ``DrivingMotion``.
        stops: failures of robots. Only ``DrivingMotion`` supports them.
        odometry: standard deviation of the measured distance, as a share of the distance; see
            ``Odometry``. It does not affect how bodies move.

    Raises:
        ValueError: a field is out of range; the message has the field, its value and what is
            allowed.

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
        """The state of floor and motors, for records of episodes."""
        return Conditions(tuple(sorted(self.slippery)), self.motor_strength)

    @property
    def any(self) -> bool:
        """Whether anything differs from the nominal physics."""
        return self.is_felt or self.odometry > 0

    @property
    def is_felt(self) -> bool:
        """Whether bodies move differently than in the nominal physics."""
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
        """Return the drag of a cell as a share of the nominal drag.

        It depends only on the seed and the cell.
        """
        spread = self._disturbances.drag_spread
        return random.Random(f"{self._seed} {cell}").uniform(1 - spread, 1 + spread)

    def force_limit(self, cell: Cell, motor_force: float, mass: float) -> float:
        """Return the largest force in N that the motor can exert on the floor of ``cell``."""
        force = self._disturbances.motor_strength * motor_force
        return min(force, self.grip_force(cell, mass))

    def grip_force(self, cell: Cell, mass: float) -> float:
        """Return the largest force in N that wheels can exert, or infinity if nothing slips."""
        is_slippery = cell in self._disturbances.slippery
        return self._disturbances.grip * mass * GRAVITY if is_slippery else math.inf

    def speed_factor(self) -> float:
        """Return a random actual speed, as a share of the commanded speed."""
        noise = self._noise.gauss(0.0, self._disturbances.actuation_noise)
        # No motor runs backwards, and twice the top speed is still safe to simulate.
        return 1.0 + min(max(noise, -1.0), 1.0)
