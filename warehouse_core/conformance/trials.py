"""Tools of the conformance checks: they drive a motion, and raise on unexpected results."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.base import Motion, Outcome, centre_of
from warehouse_core.motion.traffic import Obstacle
from warehouse_core.world.generators import random_layout
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import MOVE_DELTAS, Cell

MakeMotion = Callable[[], Motion]

STAY: Cell = (0, 0)
NORTH, EAST, SOUTH, WEST = MOVES = tuple(MOVE_DELTAS.values())

MAZE = random_layout(height=7, width=8, density=0.25, seed=3)
"""Layout of random walks. It is small, so that robots often meet walls and each other."""


class ConformanceError(AssertionError):
    """An error that a motion breaks a rule."""


class Step(NamedTuple):
    """One action of each robot, from ``starts`` to ``wanted`` cells.

    ``number`` counts the steps of a walk from 0, and ``cell_size`` is in metres.
    """

    number: int
    cell_size: float
    starts: list[Cell]
    wanted: list[Cell]
    outcomes: Sequence[Outcome]


def advance(
    motion: Motion,
    cells: list[Cell],
    displacements: list[Cell],
    loaded: list[bool],
    number: int = 0,
) -> Step:
    """Advance the robots in ``cells`` by one step, and return the step."""
    outcomes = motion.advance(displacements, loaded)
    expect(len(outcomes) == len(cells), f"{len(outcomes)} outcomes for {len(cells)} robots")
    expect(
        all(isinstance(outcome, Outcome) for outcome in outcomes),
        "it returned something else than Outcome",
    )
    pairs = zip(cells, displacements, strict=True)
    wanted = [(row + down, col + right) for (row, col), (down, right) in pairs]
    return Step(number, motion.cell_size, cells, wanted, outcomes)


def trial(
    make_motion: MakeMotion,
    layout: Layout,
    cells: list[Cell],
    displacements: list[Cell],
    loaded: bool = False,
) -> Step:
    """Advance the robots of a new motion by one step, and return the step."""
    with closing(make_motion()) as motion:
        motion.reset(layout, cells, 0)
        return advance(motion, cells, displacements, [loaded] * len(cells))


def walk(motion: Motion, robots: int, moves: int, seed: int = 0) -> Iterator[Step]:
    """Yield the steps of robots that move at random in the maze, half of them loaded."""
    stream = random.Random(seed)
    ranks = stream.sample(range(len(MAZE.open_cells)), robots)
    cells = [MAZE.open_cell(rank) for rank in ranks]
    motion.reset(MAZE, cells, seed)
    for number in range(moves):
        displacements = [stream.choice((STAY, *MOVES)) for _ in cells]
        loaded = [stream.random() < 0.5 for _ in cells]
        step = advance(motion, cells, displacements, loaded, number)
        yield step
        cells = [outcome.cell for outcome in step.outcomes]


def survey(make_motion: MakeMotion) -> Iterator[Step]:
    """Yield the steps of one robot and of four robots, with every kind of outcome."""
    for robots in (1, 4):
        with closing(make_motion()) as motion:
            yield from walk(motion, robots, moves=150)


def crowds(make_motion: MakeMotion) -> Iterator[Step]:
    """Yield the steps of two, three, four and five robots."""
    for robots in (2, 3, 4, 5):
        with closing(make_motion()) as motion:
            yield from walk(motion, robots, moves=100, seed=robots)


def outcomes_of(steps: Iterable[Step]) -> list[Outcome]:
    """Return the outcomes of all robots in all steps."""
    return [outcome for step in steps for outcome in step.outcomes]


def off_centre(row: NDArray[np.float64], cell: Cell, cell_size: float) -> float:
    """Return the distance in cells from a row of a path to the middle of ``cell``."""
    return math.dist(row[1:3], centre_of(cell, cell_size)) / cell_size


def expect(condition: bool, otherwise: str) -> None:
    """Raise ``ConformanceError`` with the message ``otherwise`` if the condition is false."""
    if not condition:
        raise ConformanceError(otherwise)


def expect_ends(step: Step, stops: Sequence[Obstacle]) -> None:
    """Expect each robot in its wanted cell, or blocked in its start if it has an obstacle."""
    for robot, (outcome, stop) in enumerate(zip(step.outcomes, stops, strict=True)):
        end = step.wanted[robot] if stop is None else step.starts[robot]
        expect(
            outcome.cell == end and outcome.blocked == (stop is not None),
            f"robot {robot} ended in {outcome.cell}, blocked {outcome.blocked}, and not in {end}, "
            f"when robots in {step.starts} wanted {step.wanted}",
        )


def expect_error(kind: type[Exception], call: Callable[..., object], *arguments: object) -> None:
    """Expect that a call raises this kind of error; other errors propagate."""
    try:
        call(*arguments)
    except kind:
        return
    raise ConformanceError(f"{kind.__name__} was not raised for {arguments}")
