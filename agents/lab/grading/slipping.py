"""Slippery floor on which moves sometimes go to a side: the simplest stochastic warehouse."""

from __future__ import annotations

import random
from collections.abc import Sequence

from warehouse_core import Cell, GridMotion, Layout, Outcome
from warehouse_core.arguments import real_number

STAY = (0, 0)


class SlippingGrid(GridMotion):
    """A motion by whole cells in which moves sometimes go to the left or right of their direction.

    After slipping, robots move as in ``GridMotion``.

    Args:
        chance: probability from 0 to 1 that a move goes to a side; both sides are equally likely.

    Raises:
        ValueError: ``chance`` is out of range.

    Source: the 4 x 3 world of Russell and Norvig, 4th ed., section 17.1, with a probability of 0.2.
    """

    def __init__(self, chance: float = 0.2) -> None:
        super().__init__()
        self.chance, self._random = real_number("chance", chance, 0, 1), random.Random()

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Place the robots, and seed the random numbers; see ``Motion.reset``."""
        super().reset(layout, cells, seed)
        self._random = random.Random(seed)

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Move every robot by one action; see ``Motion.advance``."""
        return super().advance([*map(self._slipped, displacements)], loaded)

    def _slipped(self, displacement: Cell) -> Cell:
        number = self._random.random()
        if displacement == STAY or number >= self.chance:
            return displacement
        down, right = displacement
        return (right, -down) if number < self.chance / 2 else (-right, down)
