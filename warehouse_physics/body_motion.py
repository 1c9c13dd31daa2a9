"""What all motions of bodies have: a robot, disturbances, and paths."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Self

from warehouse_core.arguments import MAX_STEPS, flag, instance_of, whole_number
from warehouse_core.motion.base import Conditions
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.spec import RobotSpec

PATH_EVERY = 10
"""Substeps between rows of a path."""


class BodyMotion:
    """Base of the motions that move bodies; see ``RigidBodyMotion`` for the arguments."""

    is_busy = False
    """True while a call is running that no other may overlap; see ``exclusive``."""

    def __init__(
        self,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        *,
        record_path: bool = True,
        path_every: int = PATH_EVERY,
    ) -> None:
        self.spec = RobotSpec() if spec is None else instance_of("spec", spec, RobotSpec)
        self.disturbances = (
            Disturbances()
            if disturbances is None
            else instance_of("disturbances", disturbances, Disturbances)
        )
        self.cell_size = self.spec.cell_size
        self._record_path = flag("record_path", record_path)
        self._path_every = whole_number("path_every", path_every, 1, MAX_STEPS)

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, float]) -> Self:
        """Return a motion of nominal robots; see ``RobotSpec.from_numbers``."""
        return cls(RobotSpec.from_numbers(numbers))

    @property
    def conditions(self) -> Conditions:
        """Floor and motors, for records."""
        return self.disturbances.conditions

    def _drawn(self, seed: int | None) -> int:
        """Return the seed for disturbances, which is drawn if none is given and it matters."""
        if seed is None and self.disturbances.any:
            # Python's global random numbers, as the chapter does.
            return random.getrandbits(32)
        return seed or 0
