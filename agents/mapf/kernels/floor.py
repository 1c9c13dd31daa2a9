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

NONE = -1
"""Number in place of an entry, a configuration or a cost where there is none."""

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
def measure(
    floor: Floor, goal: int, field: Table, heads: Buffer, entries: Buffer, below: Buffer
) -> None:
    """Write the cost of the cheapest way from each cell to a goal into a field.

    Args:
        floor: floor whose places are cells, and where a step leads back from where one leads.
        goal: cell with the distance 0.
        field: ``[size]``, all ``FAR`` before.
        heads: last entry of each bucket, one more than the highest price, all ``NONE``. The
            buckets are used in turn, as Dial (1969) does.
        entries: ``[size * 4 + 1]``, cells in buckets.
        below: ``[size * 4 + 1]``, entry before each in its bucket, or ``NONE``.
    """
    near, price, span = floor.near, floor.price, len(heads)
    field[goal], entries[0], below[0], heads[0] = 0, goal, NONE, 0
    count, waiting, distance = 1, 1, 0
    while waiting > 0:
        entry = heads[distance % span]
        if entry == NONE:
            distance += 1
            continue
        heads[distance % span], cell = below[entry], entries[entry]
        waiting -= 1
        if field[cell] != distance:
            continue  # a cheaper way was found since
        for action in range(STAY):
            before = near[cell * ACTIONS + action]
            if before == floor.closed:
                continue
            back = before * ACTIONS + (action ^ 2)
            reached = distance + price[back]
            if near[back] == cell and reached < field[before]:
                field[before] = reached
                entries[count], below[count] = before, heads[reached % span]
                heads[reached % span] = count
                count, waiting = count + 1, waiting + 1
