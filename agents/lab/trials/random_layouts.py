"""Random layouts with seeds, some of which are for training and all others for evaluation."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace

from warehouse_core import Layout, LayoutError, random_layout
from warehouse_core.world.generators import maze_layout
from warehouse_core.world.tiles import WALL

TRAINING_LAYOUTS, MAX_POOL = 2**40, 100_000
"""First seed of the layouts for training; layouts with lower seeds are for evaluation. Maximum
number of layouts in a pool, so that the pools of two training seeds share no seed."""

MAZES, SMALLEST = 0.4, 5
"""Share of mazes among varied layouts, and minimum number of their rows and of their columns."""


@dataclass(frozen=True)
class RandomLayouts:
    """Random layouts of one size, in which all open cells are connected.

    The density of each layout is a random multiple of one percent between the lowest and the
    highest density.

    Args:
        height: number of rows.
        width: number of columns.
        lowest: lowest density.
        highest: highest density.
        count: number of layouts in the pool for training, 1 to ``MAX_POOL``.
        pool_seed: seed of the pool.
        left_out: numbers of layouts that are excluded from the pool.

    Raises:
        LayoutError: the number of layouts is out of range, or ``random_layout`` does not allow a
            size or density.
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
                f"density is from {self.lowest} to {self.highest}; the first must not be higher"
            )
        if not 1 <= self.count <= MAX_POOL:
            raise LayoutError(f"the number of layouts is {self.count}; allowed: 1..{MAX_POOL}")

    @property
    def name(self) -> str:
        """Description with the size and the densities."""
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
                "larger seeds are for training"
            )
        return self._made(seed)

    def pool(self) -> list[Layout]:
        """Return the layouts for training."""
        first = TRAINING_LAYOUTS + self.pool_seed * MAX_POOL
        numbers = (number for number in range(self.count) if number not in self.left_out)
        return [self._made(first + number) for number in numbers]

    def without(self, seeds: Iterable[int]) -> RandomLayouts:
        """Return these layouts without the pool layouts that have the same walls as some episodes.

        Args:
            seeds: seeds of the episodes.

        Raises:
            LayoutError: no layout is left in the pool.
        """
        seen = {_walls(self.layout(seed)) for seed in seeds}
        pool = enumerate(replace(self, left_out=frozenset()).pool())
        left_out = frozenset(number for number, layout in pool if _walls(layout) in seen)
        if len(left_out) == self.count:
            raise LayoutError(
                f"{self.name}: each of the {self.count} training layouts is also in an exam; "
                "use a larger size or a wider range of densities"
            )
        return replace(self, left_out=left_out)

    def _made(self, seed: int) -> Layout:
        stream = random.Random(f"density {seed}")  # independent of the random walls
        density = round(stream.uniform(self.lowest, self.highest), 2)
        return random_layout(self.height, self.width, density, seed)


@dataclass(frozen=True)
class VariedLayouts(RandomLayouts):
    """Random layouts and perfect mazes of any size up to a maximum.

    Smaller layouts are filled up with walls to the maximum size, so that a batch can use all of
    them. The arguments are the arguments of ``RandomLayouts``, but height and width are the maximum
    size.
    """

    height: int = 25
    width: int = 25
    lowest: float = 0.0

    def __post_init__(self) -> None:
        if min(self.height, self.width) < SMALLEST:
            raise LayoutError(
                f"the maximum size is {self.height} x {self.width}; it must be at least "
                f"{SMALLEST} x {SMALLEST}"
            )
        super().__post_init__()

    @property
    def name(self) -> str:
        """Description with the kinds of layouts and the maximum size."""
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
