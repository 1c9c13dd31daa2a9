"""Random layouts of one size, one for each seed: some to learn in, all others to be tested in."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass

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
    """

    height: int = 7
    width: int = 12
    lowest: float = 0.1
    highest: float = 0.4
    count: int = 1024
    pool_seed: int = 1

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
        return [self._made(first + number) for number in range(self.count)]

    def check_unseen(self, seeds: Iterable[int]) -> None:
        """Raise ``LayoutError`` if the layout of an episode has the walls of one in the pool."""
        known = {_walls(layout) for layout in self.pool()}
        for seed in seeds:
            if _walls(self.layout(seed)) in known:
                raise LayoutError(
                    f"{self.name}: the layout of seed {seed} is one of the {self.count} of the "
                    "training; use a larger size, a wider range of densities or fewer layouts"
                )

    def _made(self, seed: int) -> Layout:
        stream = random.Random(f"density {seed}")  # not the stream of the walls
        density = round(stream.uniform(self.lowest, self.highest), 2)
        return random_layout(self.height, self.width, density, seed)


def _walls(layout: Layout) -> tuple[str, ...]:
    return layout.with_tiles((), (), ()).rows
