"""Random layouts of one size, one for each seed: some to learn in, all others to be tested in."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace

from warehouse_core import Layout, LayoutError, random_layout
from warehouse_core.world.generators import maze_layout
from warehouse_core.world.tiles import WALL

TRAINING_LAYOUTS = 2**40
"""Layouts with seeds from this one on are for training, those with lower ones for evaluation."""

MAX_POOL = 100_000
"""Limit on the layouts of a pool, so that the pools of two training seeds share no seed."""

MAZES = 0.4
"""Share of mazes among varied layouts."""

SMALLEST = 5
"""Fewest rows and columns of varied layouts."""


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


@dataclass(frozen=True)
class VariedLayouts(RandomLayouts):
    """Random layouts of any size up to one, and among them perfect mazes.

    Walls fill what a smaller layout leaves of the size, so that a batch can draw from all.
    """

    height: int = 25
    width: int = 25
    lowest: float = 0.0

    def __post_init__(self) -> None:
        if min(self.height, self.width) < SMALLEST:
            raise LayoutError(
                f"the largest size is {self.height} x {self.width}; it must be at least "
                f"{SMALLEST} x {SMALLEST}"
            )
        super().__post_init__()

    @property
    def name(self) -> str:
        """The sizes and kinds in words."""
        return f"random layouts and mazes of up to {self.height} x {self.width}"

    def _made(self, seed: int) -> Layout:
        stream = random.Random(f"kind {seed}")
        height, width = (stream.randint(SMALLEST, side) for side in (self.height, self.width))
        if stream.random() < MAZES:
            made = maze_layout(height - 1 + height % 2, width - 1 + width % 2, seed)
        else:
            density = round(stream.uniform(self.lowest, self.highest), 2)
            made = random_layout(height, width, density, seed).with_tiles((), (), ())
        rows = [row.ljust(self.width, WALL) for row in made.rows]
        return Layout(rows + [WALL * self.width] * (self.height - len(rows)))


def _walls(layout: Layout) -> tuple[str, ...]:
    return layout.with_tiles((), (), ()).rows
