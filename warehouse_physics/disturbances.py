"""Disturbances of the nominal physics, which are off by default and depend on a seed."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Self

from warehouse_core import Cell
from warehouse_core.arguments import (
    MAX_STEPS,
    as_cell,
    real_number,
    sequence_of,
    settle,
    whole_number,
)
from warehouse_core.motion.base import EVERYWHERE, Conditions
from warehouse_core.motion.grid import GRAVITY
from warehouse_core.wording import brief

LIMITS = {
    "actuation_noise": (0.0, 0.5),
    "grip": (0.0, 1.0),
    "motor_strength": (0.0, 1.0),
    "drag_spread": (0.0, 0.99),
    "patience": (1.0, 100.0),
    "odometry": (0.0, 0.5),
}
"""Smallest and largest value of each number in ``Disturbances``."""

SLIPPERY = "slippery"

SETTINGS = {
    "noise": "actuation_noise",
    **{name: name for name in LIMITS if name != "actuation_noise"},
    SLIPPERY: SLIPPERY,
}
"""Field of ``Disturbances`` for each setting that may follow the name of a backend."""


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
        slippery: cells with slippery floor, on which ``grip`` limits the force of the motor, or
            ``"all"`` for the whole floor.
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
    slippery: frozenset[Cell] | str = frozenset()
    grip: float = 0.03
    motor_strength: float = 1.0
    drag_spread: float = 0.0
    patience: float = 2.0
    stops: tuple[Stop, ...] = ()
    odometry: float = 0.0

    def __post_init__(self) -> None:
        for name, (minimum, maximum) in LIMITS.items():
            settle(self, **{name: real_number(name, getattr(self, name), minimum, maximum)})
        if not isinstance(self.slippery, str) or self.slippery != EVERYWHERE:
            settle(self, slippery=cells_of(self.slippery))
        try:
            settle(self, stops=sequence_of("stops", self.stops, Stop))
        except TypeError as error:
            raise ValueError(str(error)) from None

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Self:
        """Return the disturbances with these settings, which are named as in ``SETTINGS``.

        A ``grip`` without slippery cells applies to the whole floor. The cells are a text, see
        ``cells_in``.

        Raises:
            ValueError: a value is out of range.

        Example:
            >>> from warehouse_physics import Disturbances
            >>> Disturbances.from_settings({"grip": 0.05, "slippery": "4-5+4-6"}).grip
            0.05
        """
        given: dict[str, Any] = {SLIPPERY: EVERYWHERE} if "grip" in settings else {}
        for name, value in settings.items():
            field = SETTINGS[name]
            given[field] = (
                cells_in(value) if field == SLIPPERY else real_number(name, value, *LIMITS[field])
            )
        return cls(**given)

    def is_slippery(self, cell: Cell) -> bool:
        """Return whether the floor of a cell is slippery."""
        return self.slippery == EVERYWHERE or cell in self.slippery

    @property
    def conditions(self) -> Conditions:
        """The state of floor and motors, for records of episodes."""
        if isinstance(self.slippery, str):
            return Conditions(self.slippery, self.motor_strength)
        return Conditions(tuple(sorted(self.slippery)), self.motor_strength)

    @property
    def any(self) -> bool:
        """Whether anything differs from the nominal physics."""
        return self.is_felt or self.odometry > 0

    def highest_speed(self, top_speed: float) -> float | None:
        """Return the highest likely speed in m/s of a robot that slides, or ``None`` if it cannot.

        The noise is a normal distribution, so higher speeds are rare.
        """
        return top_speed * (1 + min(3 * self.actuation_noise, 1.0)) if self.is_felt else None

    @property
    def is_felt(self) -> bool:
        """Whether bodies move differently than in the nominal physics."""
        return any(
            getattr(self, each.name) != each.default
            for each in fields(self)
            if each.name not in ("grip", "patience", "odometry")
        )


def cells_of(slippery: Any) -> frozenset[Cell]:
    """Return checked cells, which may be given in any iterable."""
    try:
        return frozenset(as_cell(SLIPPERY, cell) for cell in slippery)
    except Exception:  # a user's ``__iter__`` may raise anything
        message = f"slippery is {brief(slippery)}; it must be {EVERYWHERE!r} or cells"
        raise ValueError(f"{message} (row, column)") from None


def cells_in(text: str) -> frozenset[Cell] | str:
    """Return the cells that a text such as ``4-5+4-6`` names, or ``"all"``.

    The two numbers of a cell are its row and its column.
    """
    if text == EVERYWHERE:
        return text
    if not re.fullmatch(r"[0-9]{1,9}-[0-9]{1,9}(\+[0-9]{1,9}-[0-9]{1,9})*", text):
        raise ValueError(
            f"slippery is {brief(text)}; it must be {EVERYWHERE}, or the row and column of cells, "
            "as in 4-5+4-6"
        )
    pairs = (pair.split("-") for pair in text.split("+"))
    return frozenset((int(row), int(col)) for row, col in pairs)


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
        disturbances = self._disturbances
        return disturbances.grip * mass * GRAVITY if disturbances.is_slippery(cell) else math.inf

    def speed_factor(self) -> float:
        """Return a random actual speed, as a share of the commanded speed."""
        noise = self._noise.gauss(0.0, self._disturbances.actuation_noise)
        # No motor runs backwards, and twice the top speed is still safe to simulate.
        return 1.0 + min(max(noise, -1.0), 1.0)
