"""Base of the motions of bodies: their robot, their disturbances, and copies of them."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, ClassVar, Self

from warehouse_core.arguments import MAX_STEPS, flag, instance_of, whole_number
from warehouse_core.motion.base import MAX_RAYS, BaseMotion, Outcome, Pose, centre_of
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell
from warehouse_physics.disturbances import SETTINGS, SLIPPERY, Disturbances
from warehouse_physics.energy import move_joules
from warehouse_physics.odometry import Odometry
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec

PATH_EVERY = 10
"""Default number of substeps between two rows of a path."""


MOVES = tuple(product(dict.fromkeys(DISPLACEMENTS), (False, True)))
"""Displacements of a robot, without and with an item. A noted call has one index into this per
robot."""

_NUMBERS = {move: number for number, move in enumerate(MOVES)}


class BodyMotion(BaseMotion):
    """Base of the motions that move bodies; see ``RigidBodyMotion`` for the arguments.

    A space of Chipmunk cannot be copied exactly: the copy behaves differently from the original. A
    copy or an unpickled motion therefore repeats all calls since the reset.
    """

    BODIES: ClassVar[str]
    """Name of the attribute that has the bodies, which is ``None`` before a reset."""

    WORDS = ("drive", SLIPPERY)
    """Settings of ``from_numbers`` whose values are words."""

    NUMBERS: ClassVar[tuple[str, ...]] = ()
    """Settings of ``from_numbers`` that belong to the motion itself and not to its robots."""

    is_busy = False
    """True while a call is running that no other call may overlap; see ``exclusive``."""

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        record_path: bool = True,
        path_every: int = PATH_EVERY,
    ) -> None:
        spec = RobotSpec() if spec is None else instance_of("spec", spec, RobotSpec)
        self.disturbances = (
            Disturbances()
            if disturbances is None
            else instance_of("disturbances", disturbances, Disturbances)
        )
        self.spec = spec.refined()
        self.cell_size = self.spec.cell_size
        self.conditions = self.disturbances.conditions._replace(drive=self.spec.drive)
        self.cell_joules = move_joules(self.spec, loaded=True)
        self._record_path = flag("record_path", record_path)
        self._path_every = whole_number("path_every", path_every, 1, MAX_STEPS)
        self._begun: tuple[Layout, tuple[Cell, ...], int] | None = None
        self._calls: list[tuple[str, Any]] = []
        self._odometry: Odometry | None = None

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, Any]) -> Self:
        """Return a motion with settings of its robots, its disturbances and its own.

        See ``RobotSpec.from_numbers``, ``disturbances.SETTINGS`` and ``NUMBERS``.
        """
        others = *SETTINGS, *cls.NUMBERS
        robot = {name: number for name, number in numbers.items() if name not in others}
        trouble = {name: number for name, number in numbers.items() if name in SETTINGS}
        own = {name: number for name, number in numbers.items() if name in cls.NUMBERS}
        spec = RobotSpec.from_numbers(robot, others)
        return cls(spec, Disturbances.from_settings(trouble), **own)

    def scan(self, robot: int, rays: int) -> Floats:
        """Return the distances to walls and other robots; see ``BaseMotion.scan``."""
        robot, rays = self._known(robot), whole_number("rays", rays, 1, MAX_RAYS)
        distances: Floats = getattr(self, self.BODIES).scan(robot, rays)
        return distances

    def odometry(self, robot: int) -> Pose | None:
        """Return the pose that a robot believes it has; see ``BaseMotion.odometry``."""
        robot = self._known(robot)
        return None if self._odometry is None else self._odometry.poses[robot]

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {self.BODIES: None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        if self._begun is None:
            return
        motion: Any = self
        motion.reset(*self._begun)
        for name, given in state["_calls"]:
            if name == "advance":
                motion.advance(*zip(*(MOVES[number] for number in given), strict=True))
            else:
                getattr(motion, name)(given)

    def _begin(self, layout: Layout, cells: Sequence[Cell], seed: int) -> None:
        """Note a reset, and forget the calls before it."""
        self._begun, self._calls = (layout, tuple(cells), seed), []
        if error := self.disturbances.odometry:
            starts = (centre_of(cell, self.cell_size) for cell in cells)
            self._odometry = Odometry(starts, error, seed)

    def _measured(self, outcomes: list[Outcome]) -> list[Outcome]:
        """Return the outcomes, after the odometry of the robots has measured them."""
        if self._odometry is not None:
            self._odometry.measure([outcome.path for outcome in outcomes])
        return outcomes

    def _known(self, robot: int) -> int:
        """Return the number of a robot, after a check that it exists."""
        if self._begun is None:
            raise RuntimeError("the motion needs a reset() before it")
        return whole_number("robot", robot, 0, len(self._begun[1]) - 1)

    def _note(self, name: str, given: Any) -> None:
        """Note a call with one argument, for copies to repeat."""
        self._calls.append((name, given))

    def _note_moves(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> None:
        """Note a call of ``advance``, as one byte per robot."""
        moves = zip(displacements, loaded, strict=True)
        self._note("advance", bytes(map(_NUMBERS.__getitem__, moves)))

    def _random_seed(self, seed: int | None) -> int:
        """Return the seed for disturbances, which is random if it matters and none is given."""
        if seed is None and self.disturbances.any:
            # Use Python's global random numbers, as the chapter does.
            return random.getrandbits(32)
        return seed or 0
