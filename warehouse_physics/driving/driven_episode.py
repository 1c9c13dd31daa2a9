"""The path of a finished episode, driven in one go by the body of a lone robot.

``step`` does not reveal the next action, so a body that moves step by step stops in each cell. Once
all cells are known, it can drive through them. It stops only where it must: to pick, drop or wait,
where its path turns back, and where its drive has to turn on the spot.

A *leg* is what the robot drives without having to pick, drop or wait. It is driven as a whole and
then cut into one window for each step. The window of a move ends where the body is closest to the
middle of the cell. A step that did not move the robot, such as a move into a wall, takes a single
substep, because a robot that knows its path does not try it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import compress, pairwise
from typing import Any, NamedTuple

import numpy as np

from warehouse_core import BackendError, Cell, Episode, Outcome
from warehouse_core.motion.base import Contact, centre_of
from warehouse_core.records.drive_summary import AT_REST
from warehouse_core.world.actions import DROP, PICK, WAIT, action_index
from warehouse_core.world.tables import Integers
from warehouse_physics.body_motion import PATH_EVERY
from warehouse_physics.profile import Floats, lengths_of

CHUNK = 0.5
"""Seconds of driving after which the program looks whether the robot has arrived."""

PATIENCE = 100.0
"""Seconds for each cell of a leg after which a robot counts as stuck. It also counts as stuck if it
has stood still for as long without a ``Stop``, since no move takes more than ``MAX_MOVE_SECONDS``.
"""

STAY = (0, 0)


class Trajectory(NamedTuple):
    """What a body has done in one or more calls.

    Attributes:
        rows: ``[K, 9]``, rows of the path followed by the readings; see ``Outcome``.
        contacts: hits, with seconds since the first row.
    """

    rows: Floats
    contacts: list[Contact]


def drive_cells(motion: Any, episode: Episode) -> list[Outcome]:
    """Drive the cells of a lone robot in one go, and return an outcome for each step.

    Args:
        motion: ``DrivingMotion`` with a row of its path for each substep. Its calls last as long
            as a pick.
        episode: record with the cells, the actions and the loads.

    Raises:
        BackendError: a step leads to a cell that is not a neighbour, or disturbances keep the robot
            from arriving.
    """
    motion.reset(episode.layout, [episode.cells[0]], episode.seed)
    outcomes: list[Outcome] = []
    leg: list[Cell] = []
    for step, action in enumerate(episode.actions):
        if action_index(action) in (WAIT, PICK, DROP):
            outcomes += _drive_leg(motion, leg)
            leg = []
            waited = motion.advance([STAY], [episode.loaded[step + 1]])
            outcomes.append(_window(_joined(waited), slice(None), episode.cells[step + 1]))
        else:
            leg.append(episode.cells[step + 1])
    return outcomes + _drive_leg(motion, leg)


def _drive_leg(motion: Any, cells: Sequence[Cell]) -> list[Outcome]:
    """Drive through cells and stop in the last one; return an outcome for each of them."""
    [start] = motion.routes().ends
    moves = [cell != before for cell, before in zip(cells, [start, *cells], strict=False)]
    trailing = moves[::-1].index(True) if True in moves else len(moves)
    trajectory = _drive_through(motion, [*compress(cells, moves)], trailing)
    ends = [0]
    for number, (cell, is_move) in enumerate(zip(cells, moves, strict=True), start=1):
        if is_move and True in moves[number:]:
            places = trajectory.rows[ends[-1] :, 1:3]
            ends.append(ends[-1] + _closest(places - centre_of(cell, motion.cell_size)))
        elif is_move:
            ends.append(len(trajectory.rows) - 1 - trailing)
        else:
            ends.append(ends[-1] + 1)
    parts = [slice(start, end + 1) for start, end in pairwise(ends)]
    return [_window(trajectory, *each) for each in zip(parts, cells, strict=True)]


def _drive_through(motion: Any, cells: Sequence[Cell], trailing: int) -> Trajectory:
    """Return the trajectory through cells, with a row for each substep.

    It ends ``trailing`` substeps after the robot has come to rest in the last cell.
    """
    for cell in cells:
        try:
            motion.extend([cell])
        except ValueError as error:
            raise BackendError(f"the recorded body slid over a cell: {error}") from error
    done: list[Outcome] = []
    stops = [stop.seconds for stop in motion.disturbances.stops if math.isfinite(stop.seconds)]
    moved, longest_stand = 0, PATIENCE + sum(stops)
    while not motion.routes().at_rest[0]:
        if len(done) * CHUNK > min(PATIENCE * len(cells), moved * CHUNK + longest_stand):
            x, y = done[-1].path[-1, 1:3]
            raise BackendError(
                f"the robot has not arrived in {cells[-1]} after {len(done) * CHUNK:.0f} s; it is "
                f"at x = {x:.2f} m, y = {y:.2f} m"
            )
        done += motion.drive(CHUNK)
        if math.dist(*done[-1].path[[0, -1], 1:3]) > AT_REST * CHUNK:
            moved = len(done)
    done += motion.drive((trailing + 1) * motion.spec.time_step)
    rows, contacts = _joined(done)
    last = np.flatnonzero(lengths_of(rows[:, 4:6]) > AT_REST).max(initial=-1)
    return Trajectory(rows[: last + 2 + trailing], contacts)


def _closest(offsets: Floats) -> int:
    """Return the first row, of offsets ``[K, 2]`` in metres, after which the robot moves away."""
    distances = lengths_of(offsets)
    leaves = (distances[:-1] < distances[0] / 2) & (np.diff(distances) > 0)
    return int(leaves.argmax())


def _window(trajectory: Trajectory, part: slice, cell: Cell) -> Outcome:
    """Return the outcome of a step, which is a part of a trajectory."""
    rows = trajectory.rows[part]
    rows = rows[telling(rows, PATH_EVERY)]
    begin, end = rows[0, 0], rows[-1, 0]
    rows[:, [0, 8]] -= rows[0, [0, 8]]
    contacts = tuple(
        each._replace(seconds=each.seconds - begin)
        for each in trajectory.contacts
        if begin < each.seconds <= end
    )
    rows.flags.writeable = False
    seconds, joules = rows[-1, [0, 8]].tolist()
    return Outcome(cell, False, seconds, joules, rows[:, :4], contacts, readings=rows[:, 4:])


def _joined(outcomes: Sequence[Outcome]) -> Trajectory:
    """Return the trajectory that consists of successive outcomes."""
    seconds = joules = 0.0
    parts: list[Floats] = []
    contacts: list[Contact] = []
    for outcome in outcomes:
        assert outcome.readings is not None
        rows = np.hstack([outcome.path, outcome.readings])
        rows[:, [0, 8]] += seconds, joules
        parts.append(rows[1:] if parts else rows)
        contacts += [each._replace(seconds=each.seconds + seconds) for each in outcome.contacts]
        seconds, joules = rows[-1, [0, 8]]
    return Trajectory(np.vstack(parts), contacts)


def telling(rows: Floats, every: int) -> Integers:
    """Return which rows of the path of a lone robot to keep.

    These are one row out of ``every``, and the rows at which the robot begins or ends to speed up
    or to brake, so that they include the extremes of its speed.
    """
    gains = np.diff(lengths_of(rows[:, 4:6]))
    changes = np.diff(np.sign(gains * (np.abs(gains) > AT_REST)), prepend=0)
    is_due = np.arange(len(rows)) % every == 0
    return np.flatnonzero(np.append(changes != 0, True) | is_due)
