"""Random layouts of one size, one for each seed: some to learn in, all others to be tested in."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace

from warehouse_core import Layout, LayoutError, random_layout

TRAINING_LAYOUTS = 2**40
"""Layouts with seeds from this one on are for training, those with lower ones for evaluation."""

MAX_POOL = 100_000
"""Limit on the layouts of a pool, so that the pools of two training seeds share no seed."""


@dataclass(frozen=True)
class RandomLayouts:
    """Random layouts of one size; every open cell of each can be reached.

    The density of each is drawn between the lowest and the highest, in whole percents; what
    ``random_layout`` does not allow is a ``LayoutError``.

    Args:
        count: layouts of the pool for training, 1 to ``MAX_POOL``.
        pool_seed: seed of this pool.
        left_out: numbers of layouts of the pool that are left out of it.
    """

    height: int = 7
    width: int = 12
    lowest: float = 0.1
    highest: float = 0.4
    count: int = 1024
    pool_seed: int = 1
    left_out: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        for density in (self.lowest, self.highest):
            random_layout(self.height, self.width, density, seed=0)
        if self.lowest > self.highest:
            raise LayoutError(
                f"density is from {self.lowest} to {self.highest}; the first must be the lower one"
            )
        if not 1 <= self.count <= MAX_POOL:
            raise LayoutError(f"the number of layouts is {self.count}; allowed: 1..{MAX_POOL}")

    @property
    def name(self) -> str:
        """The size and the densities in words."""
        densities = dict.fromkeys((self.lowest, self.highest))
        return (
            f"random layouts of {self.height} x {self.width} with density "
            f"{' to '.join(f'{density:g}' for density in densities)}"
        )

    def layout(self, seed: int) -> Layout:
        """Return the layout for the episode with a seed below ``TRAINING_LAYOUTS``."""
        if seed >= TRAINING_LAYOUTS:
            raise LayoutError(
                f"the seed of a random layout is {seed}; allowed: 0..{TRAINING_LAYOUTS - 1}; "
                "larger ones are for training"
            )
        return self._made(seed)

    def pool(self) -> list[Layout]:
        """Return the layouts for training."""
        first = TRAINING_LAYOUTS + self.pool_seed * MAX_POOL
        numbers = (number for number in range(self.count) if number not in self.left_out)
        return [self._made(first + number) for number in numbers]

    def without(self, seeds: Iterable[int]) -> RandomLayouts:
        """Leave out of the pool what has the walls of the layouts of some episodes.

        Raises:
            LayoutError: nothing is left.
        """
        seen = {_walls(self.layout(seed)) for seed in seeds}
        pool = enumerate(replace(self, left_out=frozenset()).pool())
        left_out = frozenset(number for number, layout in pool if _walls(layout) in seen)
        if len(left_out) == self.count:
            raise LayoutError(
                f"{self.name}: each of the {self.count} of the training is also one of the exams; "
                "use a larger size or a wider range of densities"
            )
        return replace(self, left_out=left_out)

    def _made(self, seed: int) -> Layout:
        stream = random.Random(f"density {seed}")  # not the stream of the walls
        density = round(stream.uniform(self.lowest, self.highest), 2)
        return random_layout(self.height, self.width, density, seed)


def _walls(layout: Layout) -> tuple[str, ...]:
    return layout.with_tiles((), (), ()).rows
