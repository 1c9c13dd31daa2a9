"""Checks of a batch against single motions.

A motion without a method ``batch``, or whose ``batch`` raises ValueError, passes the checks of lone
robots; without a ``fleet_batch`` it passes the check of fleets.
"""

from __future__ import annotations

import random
from contextlib import ExitStack, closing, suppress

import numpy as np

from warehouse_core.conformance.trials import MAZE, MakeMotion, expect, expect_error
from warehouse_core.motion.base import (
    NOTHING,
    WALL,
    BaseBatchMotion,
    BatchOutcome,
    Motion,
    Outcome,
    with_defaults,
)
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS
from warehouse_core.world.layout import Layout

MOVES = 60
TOLERANCE = 1e-6
"""Relative difference allowed in seconds and joules; terms may be summed in another order."""

LAYOUTS = [MAZE, Layout(["#.#.", "....", "..#."]), MAZE, Layout(["."]), Layout(["......"]), MAZE]
POOL = [Layout(rows) for rows in (["#.#.", "...."], ["..#.", ".##."], ["....", "...."])]
CHANGES = 6
FLEET_LAYOUTS, FLEET_SIZES = [MAZE, Layout(["#.#.", "....", "..#."]), MAZE], (1, 4)


def check_a_batch_moves_as_single_motions_do(make_motion: MakeMotion) -> None:
    """Each row of a batch has the cell, `blocked`, `seconds` and `joules` of a single motion."""
    with ExitStack() as open_motions:
        batch = _batch_of(make_motion, open_motions, LAYOUTS)
        if batch is not None:
            singles = [open_motions.enter_context(closing(make_motion())) for _ in LAYOUTS]
            _walk_side_by_side(batch, singles, random.Random(0), LAYOUTS)


def check_a_batch_of_fleets_moves_as_single_motions_do(make_motion: MakeMotion) -> None:
    """Each robot of a batch of fleets moves as in a single motion; `stopped_by` names its stop."""
    for robots in FLEET_SIZES:
        with ExitStack() as open_motions:
            batch = _fleet_batch_of(make_motion, open_motions, FLEET_LAYOUTS, robots)
            if batch is not None:
                motions = [make_motion() for _ in FLEET_LAYOUTS]
                singles = [open_motions.enter_context(closing(motion)) for motion in motions]
                stream = random.Random(robots)
                _walk_side_by_side(batch, singles, stream, FLEET_LAYOUTS, robots, fleet=batch)


def check_a_batch_moves_in_changed_layouts(make_motion: MakeMotion) -> None:
    """If a batch can change its layouts, its rows move as single motions do after a change too."""
    before = [POOL[number % len(POOL)] for number in range(len(LAYOUTS))]
    with ExitStack() as open_motions:
        batch = _batch_of(make_motion, open_motions, before)
        if batch is not None and batch.changes_layouts:
            singles = [open_motions.enter_context(closing(make_motion())) for _ in before]
            layouts, stream = before.copy(), random.Random(2)
            for _ in range(CHANGES):
                _walk_side_by_side(batch, singles, stream, layouts, moves=MOVES // CHANGES)
                floors = stream.sample(range(len(layouts)), len(layouts) // 2)
                for floor in floors:
                    layouts[floor] = stream.choice(POOL)
                batch.change(np.array(floors), [layouts[floor] for floor in floors])


def check_a_closed_batch_does_not_move(make_motion: MakeMotion) -> None:
    """Advancing a batch after a close raises RuntimeError; closing twice is allowed."""
    with ExitStack() as open_motions:
        batch = _batch_of(make_motion, open_motions, LAYOUTS)
        if batch is not None:
            for row, layout in enumerate(LAYOUTS):
                batch.place(np.array([row]), layout.open_cells[:1])
            batch.close()
            nothing = np.zeros(len(LAYOUTS), np.intp)
            expect_error(RuntimeError, batch.advance, nothing, nothing.astype(np.bool_))
            batch.close()


BATCH_CHECKS = (
    check_a_batch_moves_as_single_motions_do,
    check_a_batch_of_fleets_moves_as_single_motions_do,
    check_a_batch_moves_in_changed_layouts,
    check_a_closed_batch_does_not_move,
)


def _batch_of(
    make_motion: MakeMotion, open_motions: ExitStack, layouts: list[Layout]
) -> BaseBatchMotion | None:
    """Return a batch of lone robots in these layouts, or ``None`` if the motion has none."""
    motion = open_motions.enter_context(closing(make_motion()))
    with suppress(ValueError):
        return _opened(with_defaults(motion).batch(layouts), open_motions)
    return None


def _fleet_batch_of(
    make_motion: MakeMotion, open_motions: ExitStack, layouts: list[Layout], robots: int
) -> BaseBatchMotion | None:
    """Return a batch of so many robots in each layout, or ``None`` if the motion has none."""
    motion = open_motions.enter_context(closing(make_motion()))
    with suppress(ValueError):
        return _opened(with_defaults(motion).fleet_batch(layouts, robots), open_motions)
    return None


def _opened(batch: BaseBatchMotion | None, open_motions: ExitStack) -> BaseBatchMotion | None:
    """Return a batch, which is closed at last, if there is one."""
    if batch is None:
        return None
    complete: BaseBatchMotion = with_defaults(batch, BaseBatchMotion)
    return open_motions.enter_context(closing(complete))


def _walk_side_by_side(
    batch: BaseBatchMotion,
    singles: list[Motion],
    stream: random.Random,
    layouts: list[Layout],
    robots: int = 1,
    moves: int = MOVES,
    fleet: BaseBatchMotion | None = None,
) -> None:
    """Make the same random moves on both, and place the robots of some floors anew at times.

    The paths and contacts of ``fleet``, the same batch if it moves fleets, are compared too.
    """
    fresh = list(range(len(layouts)))
    for _ in range(moves):
        for floor in fresh:
            layout = layouts[floor]
            cells = stream.sample(layout.open_cells.tolist(), robots)
            batch.place(np.arange(floor * robots, (floor + 1) * robots), np.array(cells))
            singles[floor].reset(layout, layout.cells(cells), 0)
        actions = [stream.randrange(len(ACTIONS)) for _ in range(len(layouts) * robots)]
        loaded = [stream.random() < 0.5 for _ in actions]
        outcome = batch.advance(np.array(actions), np.array(loaded))
        for floor, single in enumerate(singles):
            rows = range(floor * robots, (floor + 1) * robots)
            ways = [DISPLACEMENTS[actions[row]] for row in rows]
            each = single.advance(ways, [loaded[row] for row in rows])
            for row, expected in zip(rows, each, strict=True):
                where = f"row {row} of a batch, action {ACTIONS[actions[row]]}"
                _expect_equal(outcome, row, layouts[floor], expected, where)
                if fleet is not None:
                    _expect_stop(outcome, row, robots, where)
                    again = fleet.outcomes(floor)[row % robots]
                    expect(again[:2] == expected[:2], f"{where}: outcomes() gives {again[:2]}")
        fresh = [floor for floor in range(len(layouts)) if stream.random() < 0.1]


def _expect_equal(
    outcome: BatchOutcome, row: int, layout: Layout, expected: Outcome, where: str
) -> None:
    """Expect in a row of a batch what a single motion returned."""
    end = layout.cell(outcome.cells[row])
    expect(
        end == expected.cell and bool(outcome.blocked[row]) == expected.blocked,
        f"{where}: it ended in {end}, blocked {outcome.blocked[row]}; "
        f"alone in {expected.cell}, blocked {expected.blocked}",
    )
    seconds, joules = outcome.seconds[row], outcome.joules[row]
    got, wanted = np.array([seconds, joules]), np.array(expected[2:4])
    expect(
        bool((abs(got - wanted) <= TOLERANCE * wanted).all()),
        f"{where}: it took {seconds} s and {joules} J; "
        f"alone {expected.seconds} s and {expected.joules} J",
    )


def _expect_stop(outcome: BatchOutcome, row: int, robots: int, where: str) -> None:
    """Expect that a wall or another robot of the floor stopped a robot if it was blocked."""
    stop = None if outcome.stopped_by is None else int(outcome.stopped_by[row])
    others = {*range(robots), WALL} - {row % robots}
    expect(
        stop in (others if outcome.blocked[row] else {NOTHING}),
        f"{where}: blocked {outcome.blocked[row]}, stopped by {stop}",
    )
