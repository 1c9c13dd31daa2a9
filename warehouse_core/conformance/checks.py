"""Checks of the rules in ``motion/base.py``; each raises an error if its rule is broken.

The argument of a check is a factory that returns a new motion at each call. The docstring of a
check states its rule. ``suite.py`` runs ``CHECKS`` and the checks of batches in
``batch_checks.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from itertools import pairwise

import numpy as np

from warehouse_core.conformance.trials import (
    EAST,
    MAZE,
    MOVES,
    NORTH,
    SOUTH,
    STAY,
    WEST,
    MakeMotion,
    Step,
    advance,
    crowds,
    expect,
    expect_ends,
    expect_error,
    off_centre,
    outcomes_of,
    survey,
    trial,
    walk,
)
from warehouse_core.errors import LayoutError
from warehouse_core.motion.base import WALL_CONTACT, Outcome, robot_contact
from warehouse_core.motion.traffic import Obstacle, find_stops
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

Check = Callable[[MakeMotion], None]

CENTRE_TOLERANCE = 0.1
"""Largest distance from the middle in cells; bodies stop within millimetres of it."""
JOIN_TOLERANCE = 1e-6
"""Largest gap between two paths in cells; they differ only by rounding errors."""
TIME_TOLERANCE = 1e-9
"""Largest difference of times in seconds; sums and products of time steps round differently."""
HEADING_TOLERANCE = 0.1
"""Largest angle to the east in radians, 6 degrees; finite torques hold bodies inexactly."""

CLOSET = Layout(["###", "#.#", "###"])
LEDGE = Layout(["."])
HALL = Layout(["......."] * 7)
PILLARS = Layout([".#.#.#."] * 7)


# One robot, one move.


def check_reset_puts_robots_at_rest(make_motion: MakeMotion) -> None:
    """A reset places robots at rest in the middle of their cells, heading east."""
    cells = [(1, 1), (3, 5), (6, 0)]
    with closing(make_motion()) as motion:
        outcomes_of(walk(motion, robots=4, moves=10))
        motion.reset(HALL, cells, 0)
        step = advance(motion, cells, [STAY] * 3, [False] * 3)
    for cell, outcome in zip(cells, step.outcomes, strict=True):
        drift = max(off_centre(row, cell, step.cell_size) for row in outcome.path)
        expect(drift <= CENTRE_TOLERANCE, f"{drift:.3g} cells off the middle of {cell}")
        turned = abs(math.remainder(outcome.path[0, 3], math.tau))
        expect(turned <= HEADING_TOLERANCE, f"{turned:.3g} rad off east")


def check_a_free_move_ends_in_the_next_cell(make_motion: MakeMotion) -> None:
    """A move into a free cell, in any of the four directions, ends there and is not blocked."""
    for move in MOVES:
        _expect_stops(make_motion, HALL, [(3, 3)], [move], [None])


def check_a_wall_stops(make_motion: MakeMotion) -> None:
    """A wall stops a robot: it stays, is blocked, and has contact with the wall."""
    for move in MOVES:
        _expect_stops(make_motion, CLOSET, [(1, 1)], [move], [WALL_CONTACT])


def check_the_edge_stops(make_motion: MakeMotion) -> None:
    """The edge of the grid stops a robot like a wall."""
    for move in MOVES:
        _expect_stops(make_motion, LEDGE, [(0, 0)], [move], [WALL_CONTACT])


def check_waiting_stays(make_motion: MakeMotion) -> None:
    """A robot that waits stays and is not blocked, in an open hall and between walls."""
    _expect_stops(make_motion, HALL, [(3, 3)], [STAY], [None])
    _expect_stops(make_motion, CLOSET, [(1, 1)], [STAY], [None])


def check_a_move_costs_more_than_waiting(make_motion: MakeMotion) -> None:
    """A free move costs more energy than waiting, empty and loaded."""
    for loaded in (False, True):
        waiting, *moving = (
            trial(make_motion, HALL, [(3, 3)], [displacement], loaded).outcomes[0].joules
            for displacement in (STAY, *MOVES)
        )
        expect(min(moving) > waiting, f"moves cost {moving} J, and waiting costs {waiting} J")


def check_a_new_layout_replaces_the_old(make_motion: MakeMotion) -> None:
    """After a reset with another layout, only the walls of the new layout stop robots."""
    with closing(make_motion()) as motion:
        for layout, stop in ((HALL, None), (PILLARS, WALL_CONTACT), (HALL, None)):
            motion.reset(layout, [(2, 2)], 0)
            expect_ends(advance(motion, [(2, 2)], [EAST], [False]), [stop])


# Outcomes.


def check_values_are_plain(make_motion: MakeMotion) -> None:
    """`cell` is a tuple of two int, `blocked` a bool; `seconds` is above 0, `joules` at least 0."""
    for outcome in outcomes_of(survey(make_motion)):
        cell, blocked, seconds, joules = outcome[:4]
        plain = type(cell) is tuple and [type(part) for part in cell] == [int, int]
        expect(plain and type(blocked) is bool, f"cell {cell!r}, blocked {blocked!r}")
        real = isinstance(seconds, float) and isinstance(joules, float)
        expect(
            real and 0 < seconds < math.inf and 0 <= joules < math.inf,
            f"seconds and joules are {[seconds, joules]}",
        )


def check_paths_are_well_formed(make_motion: MakeMotion) -> None:
    """A path is [K >= 2, 4] float64, finite and read-only; its times rise from 0 to `seconds`."""
    for outcome in outcomes_of(survey(make_motion)):
        path = outcome.path
        expect(
            isinstance(path, np.ndarray) and path.dtype == np.float64,
            "the path is not a float64 array",
        )
        expect(
            path.ndim == 2 and len(path) >= 2 and path.shape[1] == 4,
            f"the shape of the path is {path.shape}",
        )
        expect(bool(np.isfinite(path).all()), "the path has a number that is not finite")
        expect(not path.flags.writeable, "the path can be written to")
        times = path[:, 0]
        expect(
            times[0] == 0 and bool((np.diff(times) >= 0).all()),
            "the times of the path do not rise from 0",
        )
        end, seconds = float(times[-1]), outcome.seconds
        expect(abs(end - seconds) <= TIME_TOLERANCE, f"the path ends at {end} s of {seconds} s")


def check_paths_join_up(make_motion: MakeMotion) -> None:
    """A path starts where the previous path of the robot ended."""
    previous: Sequence[Outcome] = ()
    for step in survey(make_motion):
        for before, after in zip(previous if step.number else (), step.outcomes, strict=False):
            gap = math.dist(before.path[-1, 1:3], after.path[0, 1:3])
            expect(
                gap <= JOIN_TOLERANCE * step.cell_size, f"there is a gap of {gap} m between paths"
            )
        previous = step.outcomes


def check_paths_end_in_the_middle_of_a_cell(make_motion: MakeMotion) -> None:
    """A path ends in the middle of `cell`."""
    for step in survey(make_motion):
        for outcome in step.outcomes:
            off = off_centre(outcome.path[-1], outcome.cell, step.cell_size)
            expect(off <= CENTRE_TOLERANCE, f"{off:.3g} cells off the middle of {outcome.cell}")


def check_paths_keep_out_of_walls(make_motion: MakeMotion) -> None:
    """A path crosses only open cells."""
    for step in survey(make_motion):
        for outcome in step.outcomes:
            for x, y in outcome.path[:, 1:3] / step.cell_size:
                cell = (math.floor(y), math.floor(x))
                expect(MAZE.is_open(cell), f"a path leads over {cell}")


def check_contacts_are_well_formed(make_motion: MakeMotion) -> None:
    """A blocked robot had a contact or gave way. Each contact has valid values."""
    for step in survey(make_motion):
        for robot, outcome in enumerate(step.outcomes):
            explained = bool(outcome.contacts) or _gave_way(step, robot)
            expect(explained or not outcome.blocked, "blocked without a contact")
            times = [0.0, *(contact.seconds for contact in outcome.contacts), outcome.seconds]
            ordered = all(a <= b + TIME_TOLERANCE for a, b in pairwise(times))
            expect(ordered, f"contacts at {times[1:-1]} s of {times[-1]} s")
            others = {robot_contact(i) for i in range(len(step.starts)) if i != robot}
            for _, impulse, point, counterpart in outcome.contacts:
                expect(0 < impulse < math.inf, f"an impulse of {impulse} N·s")
                expect(counterpart in {WALL_CONTACT, *others}, f"a hit with {counterpart!r}")
                away = min(math.dist(point, place) for place in outcome.path[:, 1:3])
                expect(away <= step.cell_size, f"a hit at {point}, {away} m from the path")


def check_outcomes_are_kept_as_they_were(make_motion: MakeMotion) -> None:
    """Later moves and resets do not change an outcome."""
    with closing(make_motion()) as motion:
        kept = [(outcome, outcome.copy()) for outcome in outcomes_of(walk(motion, 2, 5))]
        outcomes_of(walk(motion, 2, 5, seed=1))
    for outcome, copy in kept:
        expect(outcome == copy, "an outcome has changed since it was returned")


# Many moves and robots.


def check_a_lone_robot_agrees_with_the_walls(make_motion: MakeMotion) -> None:
    """A single robot, empty or loaded, reaches the next cell unless that is a wall."""
    with closing(make_motion()) as motion:
        for step in walk(motion, robots=1, moves=400):
            expect_ends(step, [None if MAZE.is_open(step.wanted[0]) else WALL_CONTACT])


def check_robots_agree_with_the_traffic_rule(make_motion: MakeMotion) -> None:
    """Two to five robots move and are blocked according to the table in `motion/traffic.py`."""
    for step in crowds(make_motion):
        expect_ends(step, find_stops(MAZE, step.starts, step.wanted))


def check_traffic_same_target(make_motion: MakeMotion) -> None:
    """Two robots with the same target cell both stay."""
    _expect_stops(make_motion, HALL, [(3, 2), (3, 4)], [EAST, WEST], [1, 0])


def check_traffic_head_on(make_motion: MakeMotion) -> None:
    """Two robots whose targets are each other's cells both stay."""
    _expect_stops(make_motion, HALL, [(3, 3), (3, 4)], [EAST, WEST], [1, 0])


def check_traffic_occupied(make_motion: MakeMotion) -> None:
    """A queue behind a robot that stays is stopped, each robot by the robot ahead."""
    _expect_stops(make_motion, HALL, [(3, 1), (3, 2), (3, 3)], [EAST, EAST, STAY], [1, 2, None])


def check_traffic_following(make_motion: MakeMotion) -> None:
    """A queue behind a robot that moves away follows it."""
    _expect_stops(make_motion, HALL, [(3, 1), (3, 2), (3, 3)], [EAST] * 3, [None] * 3)


def check_traffic_cycle(make_motion: MakeMotion) -> None:
    """Robots in a ring that all move on reach their target cells."""
    ring = [(3, 3), (3, 4), (4, 4), (4, 3)]
    _expect_stops(make_motion, HALL, ring, [EAST, SOUTH, WEST, NORTH], [None] * 4)


def check_equal_runs_are_equal(make_motion: MakeMotion) -> None:
    """The same seed and actions give exactly the same outcomes, also in a new motion."""
    with closing(make_motion()) as one, closing(make_motion()) as other:
        first = outcomes_of(walk(one, 3, 40, seed=7))
        expect(outcomes_of(walk(other, 3, 40, seed=7)) == first, "a new motion differs")
        expect(outcomes_of(walk(one, 3, 40, seed=7)) == first, "the motion differs after a reset")


# Misuse.


def check_bad_moves_change_nothing(make_motion: MakeMotion) -> None:
    """Invalid displacements, or wrong numbers of arguments, only raise ValueError."""
    for robots in (1, 2):
        *some, last = moves = [EAST] * robots
        *few, _ = loads = [False] * robots
        bad = [([*some, (2, 0)], loads), ([*some, (1, 1)], loads), (some, loads), (some, few)]
        bad += [([*moves, last], loads), (moves, few), (moves, [*loads, True])]
        with closing(make_motion()) as calm, closing(make_motion()) as noisy:
            for one, other in zip(walk(calm, robots, 20), walk(noisy, robots, 20), strict=True):
                expect(list(one.outcomes) == list(other.outcomes), "a bad move changed something")
                for displacements, loaded in bad:
                    expect_error(ValueError, noisy.advance, displacements, loaded)


def check_bad_starts_change_nothing(make_motion: MakeMotion) -> None:
    """A start on a wall, off the grid or given twice, or no start, only raises LayoutError."""
    bad = [[(1, 1), (0, 0)], [(-1, 1)], [(1, 3)], [(1, 1), (1, 1)], []]
    with closing(make_motion()) as calm, closing(make_motion()) as noisy:
        for one, other in zip(walk(calm, 2, 20), walk(noisy, 2, 20), strict=True):
            expect(list(one.outcomes) == list(other.outcomes), "a bad start changed something")
            for cells in bad:
                expect_error(LayoutError, noisy.reset, CLOSET, cells, 0)


def check_advance_needs_a_reset(make_motion: MakeMotion) -> None:
    """Advancing before a reset or after closing raises RuntimeError; closing twice is allowed."""
    motion = make_motion()
    expect_error(RuntimeError, motion.advance, [EAST], [False])
    motion.reset(HALL, [(3, 3)], 0)
    motion.close()
    expect_error(RuntimeError, motion.advance, [EAST], [False])
    motion.close()


CHECKS: tuple[Check, ...] = tuple(
    check for name, check in list(globals().items()) if name.startswith("check_")
)
"""The checks of this module, in order."""


def _gave_way(step: Step, robot: int) -> bool:
    """Return whether another blocked robot came from the robot's target cell or drove to it."""
    moves = zip(step.starts, step.wanted, step.outcomes, strict=True)
    others = [move for number, move in enumerate(moves) if number != robot]
    return any(step.wanted[robot] in (start, end) and it.blocked for start, end, it in others)


def _expect_stops(
    make_motion: MakeMotion,
    layout: Layout,
    cells: list[Cell],
    displacements: list[Cell],
    stops: list[Obstacle],
) -> None:
    """Expect that ``stops`` explain a step, and that each robot has touched its obstacle."""
    step = trial(make_motion, layout, cells, displacements)
    expect_ends(step, stops)
    for outcome, stop in zip(step.outcomes, stops, strict=True):
        culprit = robot_contact(stop) if isinstance(stop, int) else stop
        felt = [contact.counterpart for contact in outcome.contacts]
        expect(culprit is None or culprit in felt, f"no contact with {culprit}, but with {felt}")
