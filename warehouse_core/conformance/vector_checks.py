"""Checks of a batch against single motions.

A motion without a method ``batch``, or whose ``batch`` raises ValueError, passes them.
"""

from __future__ import annotations

import random
from contextlib import ExitStack, closing

import numpy as np

from warehouse_core.conformance.trials import MAZE, MakeMotion, expect, expect_error
from warehouse_core.motion.base import Motion
from warehouse_core.motion.vector import Batchable, BatchMotion
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS
from warehouse_core.world.layout import Layout

MOVES = 60
TOLERANCE = 1e-6
"""Of seconds and joules, relative; terms may be summed in another order."""

LAYOUTS = [MAZE, Layout(["#.#.", "....", "..#."]), MAZE, Layout(["."]), Layout(["......"]), MAZE]


def check_a_batch_moves_as_single_motions_do(make_motion: MakeMotion) -> None:
    """Each row of a batch has the cell, `blocked`, `seconds` and `joules` of a single motion."""
    with ExitStack() as open_motions:
        batch = _batch_of(make_motion, open_motions)
        if batch is not None:
            singles = [open_motions.enter_context(closing(make_motion())) for _ in LAYOUTS]
            _walk_side_by_side(batch, singles, random.Random(0))


def check_a_closed_batch_does_not_move(make_motion: MakeMotion) -> None:
    """Advancing a batch after a close raises RuntimeError; closing twice is allowed."""
    with ExitStack() as open_motions:
        batch = _batch_of(make_motion, open_motions)
        if batch is not None:
            for row, layout in enumerate(LAYOUTS):
                batch.place(np.array([row]), layout.open_cells[:1])
            batch.close()
            nothing = np.zeros(len(LAYOUTS), np.intp)
            expect_error(RuntimeError, batch.advance, nothing, nothing.astype(np.bool_))
            batch.close()


VECTOR_CHECKS = (check_a_batch_moves_as_single_motions_do, check_a_closed_batch_does_not_move)


def _batch_of(make_motion: MakeMotion, open_motions: ExitStack) -> BatchMotion | None:
    """Return a batch in ``LAYOUTS``, or ``None`` if the motion has none."""
    motion = open_motions.enter_context(closing(make_motion()))
    if not isinstance(motion, Batchable):
        return None
    try:
        return open_motions.enter_context(closing(motion.batch(LAYOUTS)))
    except ValueError:
        return None


def _walk_side_by_side(batch: BatchMotion, singles: list[Motion], stream: random.Random) -> None:
    """Make the same random moves on both, and place some robots elsewhere at times."""
    fresh = list(range(len(LAYOUTS)))
    for _ in range(MOVES):
        for row in fresh:
            cell = int(stream.choice(LAYOUTS[row].open_cells))
            batch.place(np.array([row]), np.array([cell]))
            singles[row].reset(LAYOUTS[row], [divmod(cell, LAYOUTS[row].width)], 0)
        actions = [stream.randrange(len(ACTIONS)) for _ in singles]
        loaded = [stream.random() < 0.5 for _ in singles]
        outcome = batch.advance(np.array(actions), np.array(loaded))
        for row, single in enumerate(singles):
            expected = single.advance([DISPLACEMENTS[actions[row]]], [loaded[row]])[0]
            end = divmod(int(outcome.cells[row]), LAYOUTS[row].width)
            where = f"row {row} of a batch, action {ACTIONS[actions[row]]}: "
            expect(
                end == expected.cell and bool(outcome.blocked[row]) == expected.blocked,
                f"{where}it ended in {end}, blocked {outcome.blocked[row]}; "
                f"alone in {expected.cell}, blocked {expected.blocked}",
            )
            seconds, joules = outcome.seconds[row], outcome.joules[row]
            got, wanted = np.array([seconds, joules]), np.array(expected[2:4])
            expect(
                bool((abs(got - wanted) <= TOLERANCE * wanted).all()),
                f"{where}it took {seconds} s and {joules} J; "
                f"alone {expected.seconds} s and {expected.joules} J",
            )
        fresh = [row for row in range(len(LAYOUTS)) if stream.random() < 0.1]
