"""The places of a floor, the steps between them, and distance fields.

Places are numbers as in ``graph.py``: cells, or four times as many where robots have headings. The
cell of a place is its remainder by the number of cells.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, kernel

STAY = 4
"""Number of the action that stays; there are ``ACTIONS`` actions, N, E, S, W and this."""

ACTIONS = 5

FAR = 1 << 30
"""Distance of a place that no way leads from."""


class Floor(NamedTuple):
    """The places of a floor and the steps between them.

    Attributes:
        size: number of cells.
        closed: number of places, which stands for where no step leads.
        near: ``[places * 5]``, place that each action leads to from each place, or ``closed``.
        price: ``[places * 5]``, cost of each of these steps.
        degree: ``[size]``, cells beside each cell.
        through: ``[size]``, cells beside each cell that are no dead ends.
        step: cost of a step without lanes and turns, 1 or more.
    """

    size: int
    closed: int
    near: Buffer
    price: Buffer
    degree: Buffer
    through: Buffer
    step: int


@kernel
def measure(floor: Floor, goal: int, field: Table, queue: Buffer) -> None:
    """Write the steps from each cell to a goal into a field, ``[size]``, all ``FAR`` before.

    Steps must cost the same both ways, and places be cells; the queue is ``[size]``.
    """
    near, closed = floor.near, floor.closed
    field[goal], queue[0] = 0, goal
    first, last = 0, 1
    while first < last:
        cell, first = queue[first], first + 1
        after = field[cell] + floor.step
        for action in range(STAY):
            to = near[cell * ACTIONS + action]
            if to != closed and field[to] == FAR:
                field[to], queue[last] = after, to
                last += 1
