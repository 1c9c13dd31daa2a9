"""Checks that compare a batch with single motions.

A motion passes the checks of single robots if it has no method ``batch``, or if ``batch`` raises
ValueError. It passes the check of fleets if the same is true of ``fleet_batch``.
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
"""Relative tolerance of seconds and joules, whose terms may be added in any order."""

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
    """Each robot of a batch of fleets moves as in a single motion, with a valid `stopped_by`."""
    for robots in FLEET_SIZES:
        with ExitStack() as open_motions:
            batch = _fleet_batch_of(make_motion, open_motions, FLEET_LAYOUTS, robots)
            if batch is not None:
                motions = [make_motion() for _ in FLEET_LAYOUTS]
                singles = [open_motions.enter_context(closing(motion)) for motion in motions]
                stream = random.Random(robots)
                _walk_side_by_side(batch, singles, stream, FLEET_LAYOUTS, robots, fleet=batch)


def check_a_batch_moves_in_changed_layouts(make_motion: MakeMotion) -> None:
    """After a change of layouts, the rows of a batch still move like single motions."""
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
    """Advancing a closed batch raises RuntimeError; closing twice is allowed."""
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
    """Return a batch with one robot in each layout, or ``None`` if the motion has no batch."""
    motion = open_motions.enter_context(closing(make_motion()))
    with suppress(ValueError):
        return _opened(with_defaults(motion).batch(layouts), open_motions)
    return None


def _fleet_batch_of(
    make_motion: MakeMotion, open_motions: ExitStack, layouts: list[Layout], robots: int
) -> BaseBatchMotion | None:
    """Return a batch with several robots in each layout, or ``None`` if the motion has none."""
    motion = open_motions.enter_context(closing(make_motion()))
    with suppress(ValueError):
        return _opened(with_defaults(motion).fleet_batch(layouts, robots), open_motions)
    return None


def _opened(batch: BaseBatchMotion | None, open_motions: ExitStack) -> BaseBatchMotion | None:
    """Return a batch with all defaults, and close it at the end; ``None`` if there is none."""
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
    """Make the same random moves with a batch and with single motions, and compare them.

    Now and then, the robots of some floors are placed in new cells. If ``fleet`` is given, which is
    the same batch for fleets, its ``stopped_by`` and ``outcomes`` are checked too.
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
            chosen = [DISPLACEMENTS[actions[row]] for row in rows]
            each = single.advance(chosen, [loaded[row] for row in rows])
            for row, expected in zip(rows, each, strict=True):
                where = f"row {row} of a batch, action {ACTIONS[actions[row]]}"
                _expect_equal(outcome, row, layouts[floor], expected, where)
                if fleet is not None:
                    _expect_stop(outcome, row, robots, where)
                    again = fleet.outcomes(floor)[row % robots]
                    expect(again[:2] == expected[:2], f"{where}: outcomes() returns {again[:2]}")
        fresh = [floor for floor in range(len(layouts)) if stream.random() < 0.1]


def _expect_equal(
    outcome: BatchOutcome, row: int, layout: Layout, expected: Outcome, where: str
) -> None:
    """Expect that a row of a batch has the outcome of a single motion."""
    end = layout.cell(outcome.cells[row])
    expect(
        end == expected.cell and bool(outcome.blocked[row]) == expected.blocked,
        f"{where}: it ended in {end}, blocked {outcome.blocked[row]}; "
        f"in a single motion in {expected.cell}, blocked {expected.blocked}",
    )
    seconds, joules = outcome.seconds[row], outcome.joules[row]
    got, wanted = np.array([seconds, joules]), np.array(expected[2:4])
    expect(
        bool((abs(got - wanted) <= TOLERANCE * wanted).all()),
        f"{where}: it took {seconds} s and {joules} J; "
        f"in a single motion {expected.seconds} s and {expected.joules} J",
    )


def _expect_stop(outcome: BatchOutcome, row: int, robots: int, where: str) -> None:
    """Expect that ``stopped_by`` is a wall or another robot for blocked robots only."""
    stop = None if outcome.stopped_by is None else int(outcome.stopped_by[row])
    others = {*range(robots), WALL} - {row % robots}
    expect(
        stop in (others if outcome.blocked[row] else {NOTHING}),
        f"{where}: blocked {outcome.blocked[row]}, stopped by {stop}",
    )
