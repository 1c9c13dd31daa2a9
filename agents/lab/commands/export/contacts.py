"""The contacts of a record, step by step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warehouse_core import FleetEpisode
from warehouse_core.motion.base import WALL_CONTACT, Contact, centre_of, robot_contact
from warehouse_core.motion.batch import NOTHING, WALL
from warehouse_core.motion.grid import NOMINAL_KG, NOMINAL_SECONDS
from warehouse_core.records.episode import Episode
from warehouse_core.world.actions import DISPLACEMENTS


def contacts_of(record: Episode, step: int) -> Iterator[tuple[int, Contact]]:
    """Yield the contacts in a step, and for each the body that it is of; step 0 has none.

    Bodies are the robots and then the people, which are numbered on as counterparts too.
    """
    if step == 0:
        return
    if record.is_fleet:
        if not record.motions:
            yield from _nominal(record, step - 1)
            return
        motions = record.motions[step - 1]
    else:
        motions = (record.motions[step - 1],)
    for body, motion in enumerate(motions):
        for contact in motion.contacts:
            yield body, contact


def _nominal(record: FleetEpisode, step: int) -> Iterator[tuple[int, Contact]]:
    """Yield the contacts of ``GridMotion``, which a fleet's record does not keep."""
    size = record.cell_size
    for robot in np.flatnonzero(record.stopped_by[step] != NOTHING).tolist():
        by = int(record.stopped_by[step, robot])
        down, right = DISPLACEMENTS[int(record.actions[step, robot])]
        x, y = centre_of(record.layout.cell(record.cells[step, robot]), size)
        yield (
            robot,
            Contact(
                NOMINAL_SECONDS / 2,
                NOMINAL_KG * size / NOMINAL_SECONDS,
                (x + right * size / 2, y + down * size / 2),
                WALL_CONTACT if by == WALL else robot_contact(by),
            ),
        )
